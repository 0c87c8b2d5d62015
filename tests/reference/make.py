#!/usr/bin/env python3
"""Makes the reference numbers of the on-target tests. Needs NumPy and SciPy, and nothing of this project.

    python3 -m venv venv && venv/bin/pip install numpy scipy && venv/bin/python make.py
"""

import estimator
import filter
import image
import power
import quadratic

for topic in (filter, power, quadratic, image, estimator):
    topic.make()
