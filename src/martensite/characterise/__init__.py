"""Characterisation: numbers from laboratory tests of wires, films of air, beams and motors."""
