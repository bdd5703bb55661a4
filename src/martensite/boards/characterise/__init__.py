"""Experiments on a wire behind a board, chosen by their information for a fit."""
