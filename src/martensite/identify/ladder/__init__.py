"""From records to a model without a structure given: tests, a ladder of structures, a verdict."""
