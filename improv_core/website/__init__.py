"""Improv as a website: the page, and all of Improv that it needs in the browser itself.

It may import `page`, `session`, and `stage`; only `commands` and `classroom` import it. Begin with `browser_session`,
which runs in the browser, and `build`, which makes the website's files.
"""
