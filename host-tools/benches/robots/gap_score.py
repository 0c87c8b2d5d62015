"""What `gmr gap` made of the MuJoCo sets: right, in the set of names, wrong; alarms without effect; causes off the list.

    python gap_score.py JUDGE RESULT.jsonl

Judged by tests/reference/gap_judge/verdicts.py.
"""

import json
import sys
from collections import Counter

sys.path.insert(0, sys.argv[1])

from gap_foreign import FOREIGN, KIN
from verdicts import judge

ORDER = ("right", "twins", "tie", "extra", "WRONG", "false-tie", "unexplained", "none")


def main():
    lines = [json.loads(line) for line in open(sys.argv[2])]
    failed = [l for l in lines if "error" in l]
    lines = [{**l, "judged": judge(l)} for l in lines if "error" not in l]
    for robot in dict.fromkeys(l["robot"] for l in lines):
        own = [l for l in lines if l["robot"] == robot]
        known, free = [l for l in own if l["effect"]], [l for l in own if not l["effect"]]
        foreign = [l for l in known if l["effect"][0] in FOREIGN]
        if foreign:
            verdicts = Counter(l["verdict"] for l in foreign)
            kin = sum(l["verdict"] == "named" and set(l["named"]) <= KIN.get(l["effect"][0], set()) for l in foreign)
            print(f"{robot}: {len(foreign)} sets with a cause off the list: named {verdicts['named']} ({kin} of them a part of the "
                  f"cause), in a tie {verdicts['ambiguous']}, unexplained {verdicts['unexplained']}, none {verdicts['none']}")
            for l in foreign:
                print(f"  {l['effect'][0]:<18} seed {l['seed']}: {l['verdict']:<12} {', '.join(l['named'])}"
                      + (f"; or {', '.join(l['ties'])}" if l["ties"] else ""))
            continue

        def share(*what):
            return 100.0 * sum(l["judged"] in what for l in known) / max(len(known), 1)

        alarms = [l for l in free if l["judged"] == "alarm"]
        print(f"{robot}: {len(known)} sets with an effect: right {share('right', 'twins'):.1f} %, in the set of names "
              f"{share('right', 'twins', 'tie', 'extra'):.1f} %, wrong {share('WRONG'):.1f} %; alarms in {len(alarms)} of {len(free)} sets without")
        print("  " + "effect".ljust(28) + "".join(o.rjust(12) for o in ORDER) + "   named instead, or with it")
        for effect in dict.fromkeys(l["effect"][0] for l in known):
            some = [l for l in known if l["effect"][0] == effect]
            count = Counter(l["judged"] for l in some)
            others = Counter(n for l in some for n in l["named"] + l["ties"] if n != effect)
            print("  " + effect.ljust(28) + "".join(str(count[o] or ".").rjust(12) for o in ORDER) + "   "
                  + ", ".join(f"{n} {k}" for n, k in others.most_common(4)))
        kinds = {l["kind"]: Counter(m["judged"] == "alarm" for m in free if m["kind"] == l["kind"]) for l in free}
        print("  alarms by the sensor's noise: " + ", ".join(f"{kind} {count[True]} of {count.total()}" for kind, count in kinds.items()))
        if alarms:
            print("  alarms: " + ", ".join(f"{n or 'unexplained'} {k}" for n, k in Counter("+".join(l["named"]) for l in alarms).most_common()))
    for l in failed[:5]:
        print(f"failed: {l['robot']} {l['effect']} {l['error']}")
    if failed:
        print(f"{len(failed)} sets failed")


if __name__ == "__main__":
    main()
