"""Drawing of a run on the page: tables of numbers, made from a result."""
