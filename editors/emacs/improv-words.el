;;; improv-words.el --- The words of Improv, from editors/generate.py  -*- lexical-binding: t; -*-

;;; Commentary:

;; For `improv-mode'; what is in the lists is in improv_core/syntax/vocabulary.py.

;;; Code:

(defconst improv-statement-words
  '("beat")
  "Words of Improv that are colored as beat.")

(defconst improv-primitives
  '("forward" "backward" "left" "right" "halfleft" "halfright" "rest" "strafeleft" "straferight" "up" "down")
  "Words of Improv that are colored as primitive.")

(defconst improv-transformers
  '("reverse" "retrograde" "repeat" "reflect" "fast" "slow" "scale")
  "Words of Improv that are colored as transformer.")

(defconst improv-planes
  '("YZ" "XZ" "XY" "sagittal" "frontal" "transverse")
  "Words of Improv that are colored as plane.")

(provide 'improv-words)
;;; improv-words.el ends here
