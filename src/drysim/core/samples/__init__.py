"""Samples: one scene whose base moves by straight pieces, from step to step."""
