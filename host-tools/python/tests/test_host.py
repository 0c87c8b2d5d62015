"""What a Python program expects of a module: Ctrl-C, threads, notebooks."""

import os
import signal
import threading
import time
from xml.etree import ElementTree

import numpy as np
import pytest

import wheelwatt
from wheelwatt._draw import page, table


def test_ctrl_c_ends_the_work_soon():
    """A simulation of ten days would take hours."""
    # A shell's background jobs begin with Ctrl-C ignored, and Python leaves it so.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        ends_soon()
    finally:
        signal.signal(signal.SIGINT, before)


def ends_soon():
    killer = threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT))
    started = time.monotonic()
    killer.start()
    with pytest.raises(KeyboardInterrupt):
        wheelwatt.simulate(duration=864_000, rate=100)
    assert time.monotonic() - started < 10.0
    # Nothing of it is left: what comes then is not stopped.
    assert wheelwatt.simulate(duration=1).rows > 0


def test_other_threads_go_on_meanwhile():
    """Python's lock is free while gmr works: a thread counts on."""
    counts, ended = [0], threading.Event()

    def count():
        while not ended.is_set():
            counts[0] += 1
            time.sleep(0.001)

    counter = threading.Thread(target=count)
    counter.start()
    try:
        started = time.monotonic()
        before = counts[0]
        wheelwatt.simulate(duration=200, rate=200)
        took, counted = time.monotonic() - started, counts[0] - before
    finally:
        ended.set()
        counter.join()
    # One count takes a millisecond and what the scheduler adds; with the lock held there would be none.
    assert counted > 20 * took


def test_whoever_wants_to_hears_how_far_it_is(drives, tmp_path):
    """A log of three hundred drives is read for some tenths of a second: heard of every 20 ms."""
    heard = []
    columns = wheelwatt.read(drives[0])
    many = {name: np.tile(values, 300) for name, values in columns.items()}
    many = wheelwatt.Log({**many, "run": np.repeat(np.arange(300), columns.rows)})
    wheelwatt.progress(lambda what, done, total: heard.append((what, done, total)))
    try:
        wheelwatt.fit(many, model="eq18")
        assert any(what == "reading" for what, _, _ in heard), heard
        assert all(0 <= done <= total or total == 0 for _, done, total in heard), heard

        def enough(*_):
            raise LookupError("enough")

        wheelwatt.progress(enough)
        with pytest.raises(LookupError, match="enough"):
            wheelwatt.fit(many, model="eq18")
    finally:
        wheelwatt.progress(True)


def test_results_draw_themselves(drives, fitted):
    estimate = wheelwatt.estimate(drives[2], fitted, window=10.0)
    inspection = wheelwatt.inspect(drives[0])
    for answer in (estimate, inspection):
        assert ElementTree.fromstring(answer._repr_svg_()).tag.endswith("svg")
        assert answer.svg in answer._repr_html_()
    assert "<td>" in fitted._repr_html_()


def test_what_is_drawn_is_text_first():
    """Names come from files: none of them is markup, wherever it stands."""
    html = table("<script>", ("<script>",), [("<script>",)], ["<script>"], "<svg/>")
    assert "<script>" not in html and html.count("&lt;script&gt;") == 4
    assert "<script>" not in page("<script>") and "<svg/>" in html
