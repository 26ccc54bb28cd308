"""The page that shows robots move: its server, and in `static/` all files that the browser loads.

It may import `stage`, `outputs.simulator`, `ipc`, `preview`, `safety`, `protocol`, `ide`, and the packages below these.
Begin with `__main__`, then `server` and `routes`; in the browser, with `static/page.js`.
"""
