"""Results for people: figures and reports."""
