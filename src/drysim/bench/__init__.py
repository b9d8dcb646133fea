"""Benchmarks: speed and error of every approach and of scipy, and the hard cases."""

from __future__ import annotations
