"""Every approach and scipy on the same work: how fast, and how far off; and the hard cases."""

from __future__ import annotations
