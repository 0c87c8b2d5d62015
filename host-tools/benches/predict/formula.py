"""Open-RMF's formula on what gmr predict says of a drive: its energy is a + friction · b, b = m g · way."""

GRAVITY = 9.81
STOCK_FRICTION = 0.22  # of the demonstrations' fleets


def parts(report):
    vehicle = report["rmf_vehicle"]
    b = vehicle["mass_kg"] * GRAVITY * report["distance_m"]
    return report["rmf_j"] - vehicle["friction_coefficient"] * b, b


def tuned(training):
    """The friction with which the energies of training drives, (report, truth), come out best: least squares over the drives."""
    pairs = [(*parts(report), truth) for report, truth in training]
    above = sum(b * (truth - a) for a, b, truth in pairs)
    below = sum(b * b for _, b, _ in pairs)
    return max(above / below, 0.0) if below > 0.0 else 0.0


def task(report, truth, friction):
    a, b = parts(report)
    return {"truth": truth, "ours": report["energy_j"], "low": report["low_j"], "high": report["high_j"], "rmf": report["rmf_j"],
            "tuned": a + friction * b, "stock": a + STOCK_FRICTION * b}
