"""Emulated boards with their serial lines as ports: AVR by simavr, Cortex-M4 by QEMU."""
