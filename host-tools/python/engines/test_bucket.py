"""`gmr fleet s3://…` beside a server of S3 that is not ours (moto): the bytes of a folder, whoever cuts, kills or refuses."""

import os
import signal
import subprocess
import time

import boto3
import pytest
from between import Between
from moto.server import ThreadedMotoServer

OUTPUTS = ["grams.jsonl", "fleet.html", "fleet.json"]
SOURCE = "s3://fleet/logs"


@pytest.fixture(scope="module")
def server(fleet):
    """All logs of the fleet in the bucket `fleet`, below `logs/`; beside them what is no log."""
    moto = ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
    moto.start()
    host, port = moto.get_host_and_port()
    keys = {"aws_access_key_id": "testing", "aws_secret_access_key": "testing", "region_name": "us-east-1"}
    client = boto3.client("s3", endpoint_url=f"http://{host}:{port}", **keys)
    client.create_bucket(Bucket="fleet")
    client.create_bucket(Bucket="spoiled")
    for path in fleet.paths:
        client.upload_file(str(path), "fleet", f"logs/{path.relative_to(fleet.logs)}")
    client.put_object(Bucket="fleet", Key="logs/notes.txt", Body=b"no log")
    between = Between(host, port)
    between.client = client
    yield between
    between.close()
    moto.stop()


@pytest.fixture
def between(server):
    server.forget()
    return server


def environment(between, **further):
    ours = {name: value for name, value in os.environ.items() if not name.startswith(("AWS_", "GOOGLE_", "AZURE_"))}
    keys = {"AWS_ACCESS_KEY_ID": "testing", "AWS_SECRET_ACCESS_KEY": "testing", "AWS_REGION": "us-east-1"}
    return {**ours, **keys, "AWS_ENDPOINT": between.url, "AWS_ALLOW_HTTP": "true", **further}


def command(fleet, source, out):
    return [fleet.program, "fleet", str(source), "--coeffs", str(fleet.coefficients), "--out", str(out)]


def run(fleet, between, source, out, **further):
    return subprocess.run(command(fleet, source, out), env=environment(between, **further), capture_output=True, text=True,
                          check=False, timeout=300)


def refused(fleet, between, source, out, **further):
    """What it says, which is one line, and how it ended."""
    done = run(fleet, between, source, out, **further)
    assert done.returncode in (1, 2) and done.stdout == "" and done.stderr.count("\n") == 1, done
    print(done.stderr.strip())
    return done.stderr


def outputs(out):
    return {name: (out / name).read_bytes() for name in OUTPUTS}


def left(out):
    return [path.name for path in out.rglob("*") if path.name.startswith(".gmr-")]


@pytest.fixture(scope="module")
def of_folder(fleet, server, tmp_path_factory):
    """What the same logs give in a folder."""
    out = tmp_path_factory.mktemp("folder") / "out"
    done = run(fleet, server, fleet.logs, out)
    assert done.returncode == 0, done.stderr
    return outputs(out)


def test_a_bucket_gives_the_bytes_of_a_folder_and_is_read_once(fleet, between, of_folder, tmp_path):
    out = tmp_path / "out"
    started = time.perf_counter()
    done = run(fleet, between, SOURCE, out)
    assert done.returncode == 0, done.stderr
    print(f"{fleet.rows / (time.perf_counter() - started):.3g} rows/s", end="; ")
    assert outputs(out) == of_folder
    assert list(between.objects().values()) == [1] * len(fleet.paths) and left(out) == []
    between.forget()
    assert run(fleet, between, SOURCE, out).returncode == 0
    assert outputs(out) == of_folder and between.objects() == {}, "what has been read is not fetched again"
    # Another version of an object is another log.
    path = fleet.paths[0]
    key = f"logs/{path.relative_to(fleet.logs)}"
    try:
        between.client.upload_file(str(fleet.paths[1]), "fleet", key)
        assert run(fleet, between, SOURCE, out).returncode == 0
        assert list(between.objects()) == [f"/fleet/{key}"] and outputs(out) != of_folder
    finally:
        between.client.upload_file(str(path), "fleet", key)


def test_a_folder_by_its_url_gives_the_same(fleet, between, of_folder, tmp_path):
    done = run(fleet, between, fleet.logs.resolve().as_uri(), tmp_path / "out")
    assert done.returncode == 0 and outputs(tmp_path / "out") == of_folder, done.stderr


def test_killed_and_resumed_it_gives_the_same(fleet, between, of_folder, tmp_path):
    out = tmp_path / "out"
    between.spoil = lambda path, times: "slow"
    for goal in (3, 9, 17):
        process = subprocess.Popen(command(fleet, SOURCE, out), env=environment(between), stdout=subprocess.DEVNULL)
        while process.poll() is None and len(list(out.glob("read/*.json"))) < goal:
            time.sleep(0.005)
        assert process.poll() is None, "it was over before it was killed"
        process.kill()
        process.wait()
    assert run(fleet, between, SOURCE, out).returncode == 0
    assert outputs(out) == of_folder and left(out) == []


def test_ctrl_c_leaves_no_copies(fleet, between, tmp_path):
    out = tmp_path / "out"
    between.spoil = lambda path, times: "slow"
    process = subprocess.Popen(command(fleet, SOURCE, out), env=environment(between), stdout=subprocess.DEVNULL)
    while not list(out.glob("read/*.json")):
        time.sleep(0.005)
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=10) == 130 and left(out) == []


def test_a_connection_cut_within_an_object_goes_on_behind_what_came(fleet, between, of_folder, tmp_path):
    between.spoil = lambda path, times: "cut" if times == 1 else None
    done = run(fleet, between, SOURCE, tmp_path / "out")
    assert done.returncode == 0, done.stderr
    assert outputs(tmp_path / "out") == of_folder and set(between.objects().values()) == {2}


@pytest.mark.parametrize("how, said", [("cut", ""), ("refuse", "refuses access")])
def test_an_object_that_does_not_come_is_said_and_asked_for_again(fleet, between, of_folder, tmp_path, how, said):
    out = tmp_path / "out"
    between.spoil = lambda path, times: how if "robot=5/day=2026-11-02" in path else None
    done = run(fleet, between, SOURCE, out)
    assert done.returncode == 0, done.stderr
    (line,) = [line for line in done.stdout.splitlines() if "left out" in line and "robot=5" in line]
    print(line)
    assert said in line and "the next run tries again" in line and "23 runs" not in line
    assert "24 logs" in done.stdout and "1 of them left out" in done.stdout
    between.forget()
    assert run(fleet, between, SOURCE, out).returncode == 0
    assert outputs(out) == of_folder and len(between.objects()) == 1


def test_an_object_that_was_cut_is_said_and_the_rest_goes_on(fleet, between, tmp_path):
    for place, path in enumerate(fleet.paths[:4]):
        whole = path.read_bytes()
        body = whole[: len(whole) // 2] if place == 2 else whole
        between.client.put_object(Bucket="spoiled", Key=str(path.relative_to(fleet.logs)), Body=body)
    done = run(fleet, between, "s3://spoiled", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    (line,) = [line for line in done.stdout.splitlines() if "left out: " in line]
    assert str(fleet.paths[2].relative_to(fleet.logs)) in line and "cut off or damaged" in line


def test_what_cannot_be_listed_is_one_line(fleet, between, tmp_path):
    out = tmp_path / "out"
    assert "s3://nowhere/logs: no such bucket" in refused(fleet, between, "s3://nowhere/logs", out)
    assert "s3://fleet/elsewhere: no logs below it" in refused(fleet, between, "s3://fleet/elsewhere", out)
    assert "gopher://fleet" in refused(fleet, between, "gopher://fleet/logs", out)
    # Nobody at home, and nobody to ask for credentials either.
    nobody = {"AWS_ENDPOINT": "http://127.0.0.1:1"}
    assert "127.0.0.1:1" in refused(fleet, between, SOURCE, out, **nobody)
    assert "expected an endpoint of https, or AWS_ALLOW_HTTP=true" in refused(fleet, between, SOURCE, out, AWS_ALLOW_HTTP="false")
    asked = environment(between, AWS_METADATA_ENDPOINT="http://127.0.0.1:1")
    for name in ("AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY"):
        del asked[name]
    done = subprocess.run(command(fleet, SOURCE, out), env=asked, capture_output=True, text=True, check=False, timeout=120)
    print(done.stderr)
    assert done.returncode == 1 and done.stderr.count("\n") == 1
    assert "no credentials; expected AWS_ACCESS_KEY_ID" in done.stderr
