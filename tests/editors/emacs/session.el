;;; session.el --- A person's session with an open, wrong program  -*- lexical-binding: t; -*-

;;; Code:

(load (expand-file-name "steps" (file-name-directory load-file-name)) nil t)

(defvar flashed nil "What has flashed last.")
(advice-add 'pulse-momentary-highlight-region :before (lambda (start end &rest _) (setq flashed (buffer-substring start end))))

(let ((browse-url-browser-function #'browse-url-default-browser) (process-environment '("DISPLAY" "WAYLAND_DISPLAY")))
  (check (not (improv-playing--browses-p))) ; the server says where the page is
  (setenv "DISPLAY" ":0")
  (check (improv-playing--browses-p)))

(open-program)
(check (derived-mode-p 'improv-mode))

(await "diagnostic"
  (pcase (problems) (`(("lft" . ,text)) (string-search "did you mean `left`?" text))))
(exchange "turtle1" "anna")

(save)
(await "refusal" (told "✗ line 3: `lft` is not defined"))
(exchange "lft" "left")
(save)
(await "playing" (told "▶ anna ∞, endless at beat 120, simulator"))
(await "page" init-page)
(let ((first (await "beat" (beat))))
  (await "next beat" (> (beat) first)))
(robot "moves")

(await "forward is lit" (equal (lit) '((3 . "forward"))))
(await "left is lit" (equal (lit) '((3 . "left"))))
(goto-char (point-min))
(insert "# a line above\n")
(rest)
(await "forward is lit where it is now" (equal (lit) '((4 . "forward"))))

(goto-char (point-max))
(insert "wide = up\nbert $ repeat forward\n")
(improv-play)
(await "two dance" (told "▶ anna ∞ · bert ∞"))
(at "bert")
(improv-play-this)
(await "a line dances" (told "▶ line 6: bert ∞, endless at beat 120, simulator"))
(await "a flash" (equal flashed "bert $ repeat forward"))
(await "both are lit" (equal (mapcar #'car (lit)) '(4 6)))
(improv-play-this t)
(await "only bert is lit" (equal (lit) '((6 . "forward"))))
(at "left")
(transient-mark-mode)
(push-mark (point) t t)
(forward-word)
(improv-play-this)
(await "a region dances" (told "▶ line 4: anna 1 beat"))
(deactivate-mark)
(improv-play-name "wide")
(await "a name dances" (told "▶ wide: ghost 1 beat"))
(delete-region (progn (at "wide") (point)) (point-max))
(setq init-messages nil)
(save)
(await "the save brings all back" (told "▶ anna ∞, endless at beat 120, simulator"))
(await "forward is lit again" (equal (lit) '((4 . "forward"))))

(goto-char (point-max))
(insert "anna $ nonsense\n")
(save)
(await "refusal while it plays" (told "✗ line 5"))
(await "still lit" (lit))

(improv-seek 10000.5)
(await "seek" (> (or (beat) 0) 10000))
(await "lit there" (equal (lit) '((4 . "forward"))))
(improv-mute "anna")
(await "muted is not lit" (null (lit)))
(improv-mute "anna")
(await "lit again" (lit))

(improv-stop)
(robot "stands")
(await "nothing is left" (null (left-behind)))
(await "stopped" (equal (mode-line) " ■ stopped"))

(exchange "nonsense" "left")
(setq init-messages nil)
(improv-play)
(await "playing what is not saved" (told "▶ anna ∞, endless at beat 120, simulator"))
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
(improv-stop)

;;; session.el ends here
