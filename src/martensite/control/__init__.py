"""Control: drives that act on what is measured."""
