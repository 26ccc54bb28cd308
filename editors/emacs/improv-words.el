;;; improv-words.el --- The words of Improv, from editors/generate.py  -*- lexical-binding: t; -*-

;;; Commentary:

;; For `improv-mode'.  The words come from improv_core/syntax/vocabulary.py.

;;; Code:

(defconst improv-statement-words
  '("beat")
  "Words colored as a beat.")

(defconst improv-primitives
  '("forward" "backward" "left" "right" "halfleft" "halfright" "rest" "strafeleft" "straferight" "up" "down")
  "Words colored as a primitive.")

(defconst improv-transformers
  '("reverse" "retrograde" "repeat" "reflect" "fast" "slow" "scale" "fit" "ramp" "ease" "accumulate" "canon" "choose" "shuffle" "chance" "seed" "until" "pause")
  "Words colored as a transformer.")

(defconst improv-conditionals
  '("if" "else" "not")
  "Words colored as a conditional.")

(defconst improv-planes
  '("YZ" "XZ" "XY" "sagittal" "frontal" "transverse")
  "Words colored as a plane.")

(provide 'improv-words)
;;; improv-words.el ends here
