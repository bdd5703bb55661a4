"""From records to a model without a given structure: tests, a ladder of structures, a verdict."""
