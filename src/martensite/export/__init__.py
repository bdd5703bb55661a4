"""Ways out: martensite elements in the programs of others."""
