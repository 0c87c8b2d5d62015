"""The wheel says what the command says, byte by byte."""

import re

import numpy as np
import pytest

import gmr

WARTHOG = "host-tools/tests/data/warthog/drive.csv"


def timeless(text):
    """Without how long the solver took: no two runs take as long."""
    assert text.count('"fit_s": ') == 1
    return re.sub(r'"fit_s": [^,\n]+', "", text)


def test_inspect(command):
    found = gmr.inspect(WARTHOG, robot="warthog", plot=False)
    assert found.json() == command("inspect", "--robot", "warthog", "--json", WARTHOG)
    assert found.rows == 900 and found.summary


@pytest.mark.parametrize("model", ["signed", "eq18"])
def test_fit(command, drives, tmp_path, model):
    fit = gmr.fit(drives[:2], model=model)
    out = tmp_path / "c.toml"
    said = command("fit", "--model", model, "--json", "--out", out, *drives[:2])
    assert timeless(fit.json()) == timeless(said)
    assert fit.coefficients.text == out.read_text()
    assert [one.name for one in fit.parameters] == [one["name"] for one in fit.data["parameters"]]


def test_estimate(command, drives, fitted, tmp_path):
    estimate = gmr.estimate(drives[2], fitted, window=10.0)
    coefficients, plot = tmp_path / "c.toml", tmp_path / "p.svg"
    fitted.coefficients.save(coefficients)
    said = command("estimate", "--coeffs", coefficients, "--window", 10, "--plot", plot, "--json", drives[2])
    assert estimate.json() == said
    assert estimate.svg == plot.read_text()
    assert np.isfinite(estimate.windows["mass_kg"]).any()


def test_gap(command, tmp_path):
    logs = []
    for run in range(4):
        logs.append(tmp_path / f"{run}.csv")
        gmr.simulate(duration=10, rate=20, mass="3", seed=run).save(logs[-1])
    profile, page = tmp_path / "profile.csv", tmp_path / "page.html"
    found = gmr.gap(logs, profile=profile)
    said = command("gap", "--json", "--profile", profile, "--report", page, *logs)
    assert found.json() == said
    assert found.page == page.read_text()


def test_gram(command, drives, tmp_path):
    runs = gmr.gram(drives[:2], tmp_path / "wheel.jsonl", cutoff=2.0)
    command("gram", "--cutoff", 2, "--out", tmp_path / "command.jsonl", *drives[:2])
    assert (tmp_path / "wheel.jsonl").read_bytes() == (tmp_path / "command.jsonl").read_bytes()
    assert [run["run"] for run in runs] == [str(drive) for drive in drives[:2]]


def test_fit_grams(command, drives, tmp_path):
    """Of files of either kind, and of their rows as a table."""
    for name in ("g.jsonl", "g.parquet"):
        gmr.gram(drives[:2], tmp_path / name, cutoff=2.0)
        found = gmr.fit_grams(tmp_path / name, model="eq18", leave_one_out=True)
        said = command("fit", "--model", "eq18", "--json", "--leave-one-out", "--grams", tmp_path / name)
        assert found.json() == said
    assert len(found.left_out) == 2 and "<td>" in found._repr_html_()


def test_sums_of_columns_are_those_of_the_log(command, drives, tmp_path):
    """As an engine's workers make them, of rows in memory; and a table of them is a file of them."""
    log = gmr.read(drives[0])
    columns = [values.tobytes() for values in log.values()]
    arguments = ["gram", "--cutoff=2", "--out=none", str(drives[0])]
    rows = gmr._gmr.gram_of_columns(arguments, list(log), columns, None)
    texts, numbers = zip(*rows)
    table = dict(zip(gmr._grams.TEXTS, map(list, zip(*texts)))) | dict(zip(gmr._grams.NUMBERS, map(list, zip(*numbers))))
    command("gram", "--cutoff", 2, "--out", tmp_path / "g.jsonl", drives[0])
    assert gmr.fit_grams(table, model="eq18").json() == gmr.fit_grams(tmp_path / "g.jsonl", model="eq18").json()


def test_predict(command, drives, fitted, tmp_path):
    prediction = gmr.predict(drives[2], fitted, mass=3.0)
    coefficients, power = tmp_path / "c.toml", tmp_path / "power.csv"
    fitted.coefficients.save(coefficients)
    said = command("estimate", "--coeffs", coefficients, "--mass", 3, "--no-detection", "--power", power, "--json", drives[2])
    assert prediction.json() == said
    written = gmr.read(power)
    np.testing.assert_array_equal(prediction.predicted_w, written["told_w"])
    rmse = np.sqrt(np.mean((prediction.predicted_w - prediction.measured_w) ** 2))
    assert abs(rmse / prediction.rmse_w - 1.0) < 1e-9
    assert prediction.mass_kg == 3.0 and prediction._repr_svg_().startswith("<svg")
    nameless = gmr.Log({name: values for name, values in gmr.read(drives[2]).items() if name != "mass_kg"}, name="mine")
    with pytest.raises(gmr.Error, match="mine:mass_kg: no mass"):
        gmr.predict(nameless, fitted)


def test_simulate(command, tmp_path):
    log = gmr.simulate(duration=5, mass="1@0,2@3", seed=7, effect=["grade=0.02", "wheel-drag=0.02"])
    out = tmp_path / "s.csv"
    command("simulate", "--duration", 5, "--mass", "1@0,2@3", "--seed", 7, "--effect", "grade=0.02",
            "--effect", "wheel-drag=0.02", "--out", out)
    again = gmr.read(out)
    assert list(log) == list(again)
    for column in log:
        np.testing.assert_array_equal(log[column], again[column])


def test_refusals(command):
    """Message, place and exit code."""
    for arguments, call in [
        (["inspect", "--json", "missing.csv"], lambda: gmr.inspect("missing.csv", plot=False)),
        (["fit", "--json", "--model", "none", WARTHOG], lambda: gmr.fit(WARTHOG, model="none")),
    ]:
        with pytest.raises(gmr.Error) as caught:
            call()
        said = command(*arguments, code=caught.value.exit_code)
        assert said == f"gmr: {caught.value}\n"
