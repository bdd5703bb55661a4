"""Rules for gains, and the tests of a loop that they need."""
