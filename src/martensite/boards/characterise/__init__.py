"""Experiments on a wire behind a board, chosen for what a fit must learn."""
