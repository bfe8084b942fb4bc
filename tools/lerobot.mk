# Installs LeRobot into an environment of its own, for the tests of data sets: make -f tools/lerobot.mk
# It takes 5.5 GB, most of them CUDA, and has its own bounds on packages; Python 3.12 gives its current version.

OUT = build/lerobot
PYTHON ?= $(shell for p in python3.13 python3.12 python3; do $$p -c "" 2>/dev/null && echo $$p && break; done)

$(OUT)/done:
	$(PYTHON) -m venv $(OUT)
	$(OUT)/bin/python -m pip install --quiet --disable-pip-version-check "lerobot[dataset]>=0.4.4,<0.7"
	touch $@
