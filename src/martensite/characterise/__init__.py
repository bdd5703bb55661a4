"""Characterisation from laboratory tests of wires, films of air, beams and motors."""

from martensite.base.lazy import attach_names

__getattr__, __dir__ = attach_names(__name__)
