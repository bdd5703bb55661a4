"""What the page draws of a run: tables of numbers, made from a result."""
