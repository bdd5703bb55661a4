"""Stress–strain–temperature laws: one file per law, no law imports another."""
