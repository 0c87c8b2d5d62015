"""The wheel says what the command says, byte by byte."""

import json
import re
import subprocess
import sys

import numpy as np
import pytest

import wheelwatt

WARTHOG = "host-tools/tests/data/warthog/drive.csv"


def timeless(text):
    """Without how long the solver took: no two runs take as long."""
    assert text.count('"fit_s": ') == 1
    return re.sub(r'"fit_s": [^,\n]+', "", text)


def test_inspect(command):
    found = wheelwatt.inspect(WARTHOG, robot="warthog", plot=False)
    assert found.json() == command("inspect", "--robot", "warthog", "--json", WARTHOG)
    assert found.rows == 900 and found.summary


@pytest.mark.parametrize("model", ["signed", "eq18"])
def test_fit(command, drives, tmp_path, model):
    fit = wheelwatt.fit(drives[:2], model=model)
    out = tmp_path / "c.toml"
    said = command("fit", "--model", model, "--json", "--out", out, *drives[:2])
    assert timeless(fit.json()) == timeless(said)
    assert fit.coefficients.text == out.read_text()
    assert [one.name for one in fit.parameters] == [one["name"] for one in fit.data["parameters"]]


def test_estimate(command, drives, fitted, tmp_path):
    estimate = wheelwatt.estimate(drives[2], fitted, window=10.0)
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
        wheelwatt.simulate(duration=10, rate=20, mass="3", seed=run).save(logs[-1])
    profile, page = tmp_path / "profile.csv", tmp_path / "page.html"
    found = wheelwatt.gap(logs, profile=profile)
    said = command("gap", "--json", "--profile", profile, "--report", page, *logs)
    assert found.json() == said
    assert found.page == page.read_text()


def test_gram(command, drives, tmp_path):
    runs = wheelwatt.gram(drives[:2], tmp_path / "wheel.jsonl", cutoff=2.0)
    command("gram", "--cutoff", 2, "--out", tmp_path / "command.jsonl", *drives[:2])
    assert (tmp_path / "wheel.jsonl").read_bytes() == (tmp_path / "command.jsonl").read_bytes()
    assert [run["run"] for run in runs] == [str(drive) for drive in drives[:2]]


def test_fit_grams(command, drives, tmp_path):
    """Of files of either kind, and of their rows as a table."""
    for name in ("g.jsonl", "g.parquet"):
        wheelwatt.gram(drives[:2], tmp_path / name, cutoff=2.0)
        found = wheelwatt.fit_grams(tmp_path / name, model="eq18", leave_one_out=True)
        said = command("fit", "--model", "eq18", "--json", "--leave-one-out", "--grams", tmp_path / name)
        assert found.json() == said
    assert len(found.left_out) == 2 and "<td>" in found._repr_html_()


def test_estimate_at_a_known_mass(command, drives, fitted, tmp_path):
    estimate = wheelwatt.estimate(drives[2], fitted, mass=3.0, detection=False)
    coefficients, power = tmp_path / "c.toml", tmp_path / "power.csv"
    fitted.coefficients.save(coefficients)
    said = command("estimate", "--coeffs", coefficients, "--mass", 3, "--no-detection", "--power", power, "--json", drives[2])
    assert estimate.json() == said
    written = wheelwatt.read(power)
    np.testing.assert_array_equal(estimate.power["told_w"], written["told_w"])
    rmse = np.sqrt(np.mean((estimate.power["told_w"] - estimate.power["measured_w"]) ** 2))
    assert abs(rmse / estimate.data["told"]["rmse_w"] - 1.0) < 1e-9


def test_predict(command, drives, fitted, tmp_path):
    """A plan from memory, and a log's speeds as a plan."""
    plan = tmp_path / "plan.csv"
    plan.write_text("distance_m,speed_m_s\n2,0.2\n4,0.1\n", encoding="utf-8")
    coefficients = tmp_path / "c.toml"
    fitted.coefficients.save(coefficients)
    for what in (plan, drives[2]):
        prediction = wheelwatt.predict(what, fitted, mass=3.0, mass_interval=(2.9, 3.1))
        said = command("predict", "--coeffs", coefficients, "--mass", 3, "--mass-interval", "2.9,3.1", "--plan", what, "--json")
        assert prediction.json() == said
        assert prediction.low_j < prediction.energy_j < prediction.high_j
    columns = {"distance_m": [2.0, 4.0], "speed_m_s": [0.2, 0.1]}
    in_memory = wheelwatt.predict(wheelwatt.Log(columns, name="plan"), fitted, mass=3.0)
    assert in_memory.energy_j == wheelwatt.predict(plan, fitted, mass=3.0).energy_j
    assert len(in_memory.legs) == 2 and "<td>" in in_memory._repr_html_()


def test_look(command, drives):
    look = wheelwatt.look(drives[2])
    assert look.json() == command("look", "--json", drives[2])
    assert look.data["energy_j"] > 0.0 and look.page.startswith("<!DOCTYPE html>")


def test_export(command, drives, tmp_path):
    fitted = wheelwatt.fit(drives[:2])
    fitted.coefficients.save(tmp_path / "c.toml")
    export = wheelwatt.export(fitted, "mjcf", mass=2.0)
    assert export.json() == command("export", "mjcf", "--coeffs", tmp_path / "c.toml", "--mass", 2, "--json")
    assert export.text == command("export", "mjcf", "--coeffs", tmp_path / "c.toml", "--mass", 2)


def test_compare(command, drives):
    """Times to fit differ from run to run; all else is the command's."""
    chosen = ("eq18", "linear")
    comparison = wheelwatt.compare(drives[:2], drives[2], models=chosen)
    said = json.loads(command("compare", "--models", ",".join(chosen), "--json", "--train", *drives[:2], "--test", drives[2]))
    for model in (*said["models"], *comparison.models):
        del model["fit_s"]
    assert sorted(said["models"], key=lambda model: model["rmse_w"]) == list(comparison.models)
    assert "<svg" in comparison.svg


def test_the_script_is_the_command(command):
    """Its exit code too. In a process of its own: it catches Ctrl-C, once a process."""
    for arguments in (["look", "--json", WARTHOG], ["look", "missing.csv"]):
        run = [sys.executable, "-c", "import sys; from wheelwatt._script import main; sys.exit(main())", *arguments]
        done = subprocess.run(run, capture_output=True, text=True, check=False)
        assert (done.stdout if done.returncode == 0 else done.stderr) == command(*arguments, code=done.returncode)


def test_simulate(command, tmp_path):
    log = wheelwatt.simulate(duration=5, mass="1@0,2@3", seed=7, effect=["grade=0.02", "wheel-drag=0.02"])
    out = tmp_path / "s.csv"
    command("simulate", "--duration", 5, "--mass", "1@0,2@3", "--seed", 7, "--effect", "grade=0.02",
            "--effect", "wheel-drag=0.02", "--out", out)
    again = wheelwatt.read(out)
    assert list(log) == list(again)
    for column in log:
        np.testing.assert_array_equal(log[column], again[column])


def test_refusals(command):
    """Message, place and exit code."""
    for arguments, call in [
        (["inspect", "--json", "missing.csv"], lambda: wheelwatt.inspect("missing.csv", plot=False)),
        (["fit", "--json", "--model", "none", WARTHOG], lambda: wheelwatt.fit(WARTHOG, model="none")),
    ]:
        with pytest.raises(wheelwatt.Error) as caught:
            call()
        said = command(*arguments, code=caught.value.exit_code)
        assert said == f"gmr: {caught.value}\n"
