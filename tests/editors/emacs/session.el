;;; session.el --- A person's session with an open, wrong program  -*- lexical-binding: t; -*-

;;; Code:

(load (expand-file-name "steps" (file-name-directory load-file-name)) nil t)

(open-program)
(check (derived-mode-p 'improv-mode))
(check (equal (mapcar #'color '("repeat" "forward" "beat" "turtle1" "120"))
              '(font-lock-keyword-face font-lock-function-call-face font-lock-preprocessor-face font-lock-type-face
                font-lock-number-face)))

(await "diagnostic"
  (pcase (problems) (`(("lft" . ,text)) (string-search "did you mean `left`?" text))))
(await "hover" (string-search "1 beat, 0.50 s at beat 120" (documentation-at "forward")))
(let ((words (completions-behind "repeat (for")))
  (check (equal words '("forward")) words))
(at "turtle1")
(eglot-rename "anna")
(await "rename" (string-search "anna $" (buffer-string)))

(save)
(await "refusal" (told "✗ line 3: `lft` is not defined"))
(exchange "lft" "left")
(save)
(await "playing" (told "▶ anna ∞, endless at beat 120, simulator"))
(await "end of the diagnostic" (null (problems)))
(await "page" init-page)
(let ((first (await "beat" (beat))))
  (await "next beat" (> (beat) first)))
(robot "moves")

(await "forward is lit" (equal (lit) '((3 . "forward"))))
(await "left is lit" (equal (lit) '((3 . "left"))))
(goto-char (point-min))
(insert "# a line above\n")
(await "forward is lit where it is now" (equal (lit) '((4 . "forward"))))

(goto-char (point-max))
(insert "anna $ nonsense\n")
(save)
(await "refusal while it plays" (told "✗ line 5"))
(robot "moves")
(await "still lit" (lit))

(improv-pause)
(await "pause" (string-match-p "‖ [0-9]+/∞ 120 bpm" (mode-line)))
(improv-seek 10000.5) ; beyond what has been told yet
(await "seek" (string-match-p "‖ 10001/∞" (mode-line)))
(await "lit there" (equal (lit) '((4 . "forward"))))
(improv-resume)
(await "resume" (> (or (beat) 0) 10000))
(improv-mute "anna")
(await "muted is not lit" (null (lit)))
(robot "stands")
(improv-mute "anna")
(await "lit again" (lit))

(improv-hush)
(robot "stands")
(await "nothing is left" (null (left-behind)))
(await "stopped" (equal (mode-line) " ■ stopped"))

(exchange "nonsense" "left")
(exchange "repeat" "until cue repeat")
(improv-play)
(robot "moves")
(improv-cue)
(robot "stands")
(await "ended" (equal (mode-line) " ■ ended"))
(at "until")
(delete-char (length "until cue "))
(setq init-messages nil)
(improv-play)
(await "playing what is not saved" (told "▶ anna ∞, endless at beat 120, simulator"))
(robot "moves")
(await "lit by the command" (lit))

(setq init-messages nil)
(improv-before)
(await "the version before plays" (told "▶ anna"))
(let ((program (buffer-string)))
  (save-window-excursion
    (cl-letf (((symbol-function 'completing-read) (lambda (_prompt table &rest _) (nth 1 (all-completions "" table)))))
      (call-interactively #'improv-history))
    (check (equal (with-current-buffer "*Improv history*" (buffer-string)) program)
           (with-current-buffer "*Improv history*" (buffer-string)) program)))
(set-buffer (find-buffer-visiting (getenv "IMPROV_PROGRAM")))
(set-buffer-modified-p nil)
(kill-buffer)
(await "nothing is left of the buffer" (null (left-behind)))
(robot "moves")
(improv-hush)
(robot "stands")
(kill-emacs 0)

;;; session.el ends here
