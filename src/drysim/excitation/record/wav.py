"""WAV: sound files, as recorders of vibration write them. Knows the samples, not their unit."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim.errors import RecordError
from drysim.excitation.record.channels import Channel, Channels, channels
from drysim.excitation.record.columns import Floats, Label
from drysim.excitation.record.file import File, fault
from drysim.excitation.record.format import AS_CHANNEL, NO_TABLE, OWN_STEP, Format
from drysim.excitation.record.reader import Reader
from drysim.excitation.record.stored import Stored

PCM, FLOAT, EXTENSIBLE = 1, 3, 0xFFFE
"""How samples are coded; the last says that its own code stands further on."""

CODINGS = {
    (PCM, 8): "u1",
    (PCM, 16): "<i2",
    (PCM, 24): "u1",
    (PCM, 32): "<i4",
    (FLOAT, 32): "<f4",
    (FLOAT, 64): "<f8",
}
"""Code and bits of a sample, and the numbers that numpy reads; of 24 bits, three bytes."""


class Form(NamedTuple):
    """How the samples of a WAV are laid out; `rate` is per second."""

    code: int
    bits: int
    channels: int
    rate: int


def columns(file: File) -> Channels:
    """Give the channels of a WAV file.

    Raises
    ------
    RecordError
        When it is no WAV, is cut short, or has samples of a kind that is not read.
    """
    form, start, size = _chunks(file)
    each = form.bits // 8 * form.channels
    if size < each:
        raise fault(file.shown, "the WAV holds no samples")
    if size % each:
        raise _wrong(file, "its last sample is not whole")
    ways = [Frames(file, start, size // each, number, form) for number in range(form.channels)]
    found = [Channel(Label("", ""), way.stored, 1 / form.rate) for way in ways]
    return channels(file, found, shares=form.code == PCM)


def _chunks(file: File) -> tuple[Form, int, int]:
    """Give the form of the samples, and where in the file they begin and how long they are."""
    raw, at, form = file.reader, 12, None
    if raw[:4] in (b"RF64", b"RIFX"):
        kind = raw[:4].decode()
        raise fault(file.shown, f"the record is {kind}, of which only RIFF is read; convert it")
    if raw[:4] != b"RIFF" or raw[8:12] != b"WAVE":
        raise fault(file.shown, "the record is no WAV: it does not begin as one")
    while at + 8 <= len(raw):
        name, size = raw[at : at + 4], _number(raw, at + 4, 4)
        if at + 8 + size > len(raw):
            missing = at + 8 + size - len(raw)
            raise _wrong(file, f"{missing} bytes are missing at its end")
        if name == b"fmt ":
            form = _form(file, raw[at + 8 : at + 8 + size])
        if name == b"data":
            if form is None:
                raise _wrong(file, "its samples come before their form")
            return form, at + 8, size
        at += 8 + size + size % 2
    raise _wrong(file, "it has no samples")


def _form(file: File, chunk: bytes) -> Form:
    if len(chunk) < 16:
        raise _wrong(file, "the form of its samples is too short")
    code, bits = _number(chunk, 0, 2), _number(chunk, 14, 2)
    if code == EXTENSIBLE and len(chunk) >= 26:
        code = _number(chunk, 24, 2)
    form = Form(code, bits, _number(chunk, 2, 2), _number(chunk, 4, 4))
    if (code, bits) not in CODINGS:
        kinds = "whole numbers of 8, 16, 24, 32 bits and floating point of 32, 64"
        sentence = f"the WAV has samples of {bits} bits in code {code}; what is read: {kinds}"
        raise fault(file.shown, sentence)
    if not form.channels or not form.rate:
        raise _wrong(file, f"it has {form.channels} channels at {form.rate} Hz")
    if _number(chunk, 12, 2) != bits // 8 * form.channels:
        raise _wrong(file, "the sizes that it gives for its samples do not fit")
    return form


class Frames(NamedTuple):
    """One channel: where in a file its frames begin, and how many there are."""

    file: File
    start: int
    length: int
    number: int
    form: Form

    def stored(self) -> Stored:
        """Give the samples, which stay in the file."""
        return Stored(self.read, 0, self.length)

    def read(self, first: int, last: int) -> Floats:
        """Give some samples, whole numbers as shares of full scale."""
        code, bits, channels, _ = self.form
        each = bits // 8 * channels
        raw = self.file.reader[self.start + first * each : self.start + last * each]
        flat = np.frombuffer(raw, CODINGS[code, bits])
        frames = flat.reshape(last - first, channels, -1)[:, self.number]
        return _shares(frames, code, bits)


def _shares(frames: NDArray[np.generic], code: int, bits: int) -> Floats:
    """Give the numbers of frames of shape (n, 1) or, of 24 bits, (n, 3)."""
    if code == FLOAT:
        return frames[:, 0].astype(np.float64)
    if bits == 24:
        wide = np.zeros((len(frames), 4), np.uint8)
        wide[:, 1:] = frames
        return wide.view("<i4")[:, 0] / 2.0**31
    shares = frames[:, 0].astype(np.float64)
    if bits == 8:
        shares -= 128.0
    shares /= 2.0 ** (bits - 1)
    return shares


def _number(raw: Reader | bytes, at: int, size: int) -> int:
    return int.from_bytes(raw[at : at + size], "little")


def _wrong(file: File, what: str) -> RecordError:
    return fault(file.shown, f"the WAV is cut short or damaged: {what}")


FORMAT = Format(
    "a WAV",
    columns,
    {
        "skip": NO_TABLE,
        "column": AS_CHANNEL,
        "time": OWN_STEP,
        "rate": OWN_STEP,
        "step": OWN_STEP,
    },
)
