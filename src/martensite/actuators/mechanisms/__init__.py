"""Mechanisms: what the element pulls on. One file each."""
