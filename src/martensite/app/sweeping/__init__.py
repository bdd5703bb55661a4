"""What the calls about sweeps share: requests, the folder of stores, and what is drawn of them."""
