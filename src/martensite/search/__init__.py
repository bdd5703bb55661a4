"""Search and inference: what fits, designs and identified models share."""
