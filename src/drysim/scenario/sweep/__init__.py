"""The sweep block: from its words to axes, and from the axes to the case at each point."""
