"""Drawing of a run on the page: tables of numbers from a result."""
