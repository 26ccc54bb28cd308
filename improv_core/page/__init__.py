"""The page that shows robots move: its server, and in `static/` all files that the browser loads.

It may import `preview`, `protocol`, `ide`, and the packages below these. Begin with `server`, then `routes`; in the
browser, with `static/page.js`.
"""
