"""What an answer is worth.

right         the truth alone
tie           in doubt, the truth among those named; `twins` if all others are true twins of it (design page, point 9)
extra         named without doubt: the truth and something else
WRONG         named without doubt, and the truth is not among it
false-tie     in doubt, and the truth is not among it
unexplained   structure, no name
none          no structure seen
alarm         anything but `none` on a set without effect
"""

from effects import DICTIONARY, KIN

TWINS = [{"viscous-change", "lubricant-warm-up"}, {"viscous-change", "windage"}, {"supply-sag", "gear-load-loss"},
         {"wheel-drag", "sensor-gain"}]


def twins(a, b):
    return {a, b} in TWINS


def judge(line):
    truth, verdict = list(line["effect"]), line["verdict"]
    named = set(line["named"])
    if not truth:
        return "none" if verdict == "none" else "alarm"
    if verdict in ("none", "unexplained"):
        return verdict
    everything = named | set(line["ties"])
    if len(truth) == 2:
        seen = [name in everything for name in truth]
        if verdict == "named":
            return "both" if named == set(truth) else "one" if named < set(truth) else "extra" if named & set(truth) else "WRONG"
        return "both-tie" if all(seen) else "one-tie" if any(seen) else "false-tie"
    truth = truth[0]
    if truth not in DICTIONARY:
        kin = KIN.get(truth, set())
        if verdict == "named":
            return "kin" if named <= kin else "WRONG"
        return "kin-tie" if everything & kin else "false-tie"
    if verdict == "named":
        return "right" if named == {truth} else "extra" if truth in named else "WRONG"
    if truth in everything:
        return "twins" if all(name == truth or twins(name, truth) for name in everything) else "tie"
    return "false-tie"
