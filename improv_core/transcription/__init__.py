"""From motion to words: timed poses of robots → a short program (docs/transcription.md).

May import `score`, `robots`, and messages of `outputs.cdr`. Begin with `transcribe`, which calls the
others in their order. `track` holds poses and their noise; `fits` and `stretches` split them where velocities change;
`tempo` and `rhythm` put them on beats; `grouping` and `rounding` make them agree, in round numbers; `performing`
compares them with tracks; `wording`, `writing`, `folding`, and `ensemble` find words, what comes back, and what robots
do together. `reading` reads files.
"""
