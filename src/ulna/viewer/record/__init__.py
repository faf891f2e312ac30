"""Pictures and videos with no display: the same picture as on the page, painted by this machine's processor alone."""
