"""Reaches by the thousand: predicted, paced and judged in batches, written in chunks."""
