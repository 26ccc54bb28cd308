"""Improv as a website: the page, and all of Improv that it needs in the browser itself."""
