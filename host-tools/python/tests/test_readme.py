"""The example of the README runs as it stands, from the top of a checkout."""

import json
import pathlib
import re


def test_the_example_runs(command, capsys):
    text = pathlib.Path("README.md").read_text(encoding="utf-8")
    (example,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    exec(compile(example, "README.md", "exec"), {})
    printed = capsys.readouterr().out
    log = "host-tools/tests/data/warthog/drive.csv"
    fit = json.loads(command("fit", "--robot", "warthog", "--json", log))
    inspection = json.loads(command("inspect", "--robot", "warthog", "--json", log))
    assert inspection["verdict"] in printed and f"R² {fit['r2']:.2f}\n" in printed
    for parameter in fit["parameters"]:
        assert f"{parameter['name']} {parameter['value']} " in printed
