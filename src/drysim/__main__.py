"""Lets `python -m drysim` be the command `drysim`."""

import sys

from drysim.cli import main

sys.exit(main())
