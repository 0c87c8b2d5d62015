"""Tables of what batch.py kept:  python tally.py RESULT.jsonl [--failures FILE]"""

import argparse
import json
from collections import Counter

import numpy as np

from effects import DICTIONARY

ORDER = ["right", "twins", "tie", "extra", "WRONG", "false-tie", "unexplained", "none"]


def share(lines, *what):
    return f"{100.0 * sum(l['judged'] in what for l in lines) / max(len(lines), 1):5.1f} %"


COLUMNS = ["sets", "  right", "or twins", "in the set", "  wrong", "false tie", "unexplained", "   none", "closed", "seconds"]


def header():
    print("  " + "".ljust(40) + "  ".join(COLUMNS))


def figures(title, lines):
    closed = [l["closed"] for l in lines if l["closed"] is not None and l["judged"] in ("right", "twins", "tie", "extra")]
    cells = [str(len(lines)), share(lines, "right"), share(lines, "right", "twins"), share(lines, "right", "twins", "tie", "extra"),
             share(lines, "WRONG"), share(lines, "false-tie"), share(lines, "unexplained"), share(lines, "none"),
             f"{np.median(closed):.2f}" if closed else "-", f"{np.median([l['seconds'] for l in lines]):.1f}"]
    print("  " + title.ljust(40) + "  ".join(cell.rjust(len(column)) for cell, column in zip(cells, COLUMNS)))


def confusion(lines, order=ORDER):
    print("  " + "effect".ljust(27) + "".join(w.rjust(12) for w in order) + "   named instead (or with it)")
    for name in dict.fromkeys(l["effect"][0] for l in lines):
        own = [l for l in lines if l["effect"][0] == name]
        count = Counter(l["judged"] for l in own)
        instead = Counter(n for l in own if l["judged"] in ("WRONG", "extra", "false-tie") for n in l["named"] if n != name)
        ties = Counter(n for l in own if l["judged"] == "tie" for n in l["named"] + l["ties"] if n != name)
        text = ", ".join(f"{n} {k}" for n, k in instead.most_common(4))
        if ties:
            text += "  | tied with " + ", ".join(f"{n} {k}" for n, k in ties.most_common(4))
        print("  " + name.ljust(27) + "".join((str(count[w]) if count[w] else ".").rjust(12) for w in order) + "   " + text)


def reliability(lines):
    """Each effect's probability beside how often it was there: calibrated where they are alike."""
    pairs = [(p, name in l["effect"]) for l in lines for name, p in l["rivals"].items()]
    edges = [0.0, 0.01, 0.05, 0.2, 0.5, 0.8, 0.95, 1.0]
    print("  probability of an effect   effects   mean probability   was there")
    for low, high in zip(edges, edges[1:]):
        own = [(p, there) for p, there in pairs if low <= p < high or p == high == 1.0]
        if own:
            p, there = np.mean(own, axis=0)
            print(f"  {low:.2f} to {high:.2f}               {len(own):7d}            {p:7.3f}     {there:7.3f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("result", nargs="+")
    parser.add_argument("--failures")
    a = parser.parse_args()
    lines = [json.loads(line) for name in a.result for line in open(name)]
    errors = [l for l in lines if "error" in l]
    lines = [l for l in lines if "error" not in l]
    for mode in dict.fromkeys(l["mode"] for l in lines):
        here = [l for l in lines if l["mode"] == mode]
        print(f"==== mode {mode} ====")
        known = [l for l in here if len(l["effect"]) == 1 and l["effect"][0] in DICTIONARY]
        # A limit of physics keeps some below the wanted size: they are judged at what they reached.
        if known:
            header()
        for title, some in [("size reached 0.45 and more", [l for l in known if l["reached"][0] >= 0.45]),
                            *[(f"wanted size {s}, reached within 10 %", [l for l in known if l["size"] == s and l["reached"][0] >= 0.9 * s])
                              for s in sorted({l["size"] for l in known})],
                            ("below size 0.45", [l for l in known if l["reached"][0] < 0.45])]:
            if some:
                figures(title, some)
        large = [l for l in known if l["reached"][0] >= 0.45]
        for robot in dict.fromkeys(l["robot"] for l in large):
            figures(f"{robot}, size reached 0.45 and more", [l for l in large if l["robot"] == robot])
        if large:
            print("by effect, size reached 0.45 and more")
            confusion(large)
        told = [l for l in here if l["rivals"] and len(l["effect"]) < 2 and set(l["effect"]) <= set(DICTIONARY)]
        if told:
            print(f"reliability, {len(told)} sets with one effect or none")
            reliability(told)
        free = [l for l in here if not l["effect"]]
        for robot in dict.fromkeys(l["robot"] for l in free):
            own = [l for l in free if l["robot"] == robot]
            by = {k: [l for l in own if l["kind"] == k] for k in dict.fromkeys(l["kind"] for l in own)}
            print(f"effect-free, {robot}: {len(own)} sets, alarms {share(own, 'alarm')} "
                  + str(Counter(l["verdict"] for l in own if l["judged"] == "alarm"))
                  + " by noise: " + ", ".join(f"{k} {share(v, 'alarm').strip()} of {len(v)}" for k, v in by.items()))
        foreign = [l for l in here if len(l["effect"]) == 1 and l["effect"][0] not in DICTIONARY]
        if foreign:
            print(f"foreign effects: {len(foreign)} sets, wrong single name {share(foreign, 'WRONG')}, kin named {share(foreign, 'kin')},"
                  f" in doubt {share(foreign, 'false-tie', 'kin-tie')}, unexplained {share(foreign, 'unexplained')}, none {share(foreign, 'none')}")
            confusion(foreign, ["kin", "kin-tie", "WRONG", "false-tie", "unexplained", "none"])
        pairs = [l for l in here if len(l["effect"]) == 2]
        if pairs:
            print(f"pairs: {len(pairs)} sets", dict(Counter(l["judged"] for l in pairs)))
    print(f"errors: {len(errors)}", *[e["error"] for e in errors[:5]])
    if a.failures:
        with open(a.failures, "w") as out:
            for l in lines:
                if l["judged"] in ("WRONG", "extra", "false-tie", "alarm", "none", "unexplained") and not (l["judged"] in ("none", "unexplained") and (not l["effect"] or l["effect"][0] not in DICTIONARY)):
                    out.write(f"{l['judged']:11} {l['mode']} {l['robot']} {'+'.join(l['effect']) or 'free'} size {l['size']} (reached {[round(x, 2) for x in l['reached']]}, "
                              f"magnitude {[float(f'{x:.3g}') for x in l['magnitude']]}) variant {l['variant']} seed {l['seed']} noise {l['kind']} {l['memory']}: {l['verdict']} {l['named']} "
                              f"ties {l['ties']} closed {l['closed'] if l['closed'] is None else round(l['closed'], 2)} | {[[round(o[0], 1), round(o[1], 1), o[2]] for o in l['outcome']]} | best {l.get('best')}\n")


if __name__ == "__main__":
    main()
