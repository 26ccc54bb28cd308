;; -*- no-byte-compile: t; lexical-binding: nil -*-
(define-package "improv-mode" "0.1.0"
  "Live-code robot motion."
  '((emacs "30.1"))
  :keywords '("languages" "multimedia")
  :authors '("The Improv authors"))
