;;; steps.el --- What a person does and sees; each waits for what is to be seen  -*- lexical-binding: t; -*-

;;; Code:

(require 'cl-lib)

(defconst limit 60 "Seconds, for a busy machine.")

(defmacro await (what &rest seen)
  "Wait until the forms SEEN are true; say WHAT was awaited if they never are."
  `(let ((end (+ (float-time) limit)) value)
     (while (not (setq value (progn ,@seen)))
       (when (> (float-time) end)
         (error "%s was not seen; messages:\n%s" ,what (string-join (reverse init-messages) "\n")))
       (accept-process-output nil 0.05))
     (princ (format "%s\n" ,what))
     value))

(defun check (right &rest otherwise)
  "Fail unless RIGHT, showing OTHERWISE."
  (unless right (error "Wrong: %S" otherwise)))

(defun rest ()
  "Rest from typing, which Emacs in batch never notices: have Eglot send what was typed."
  (timer-event-handler (await "what was typed" eglot--change-idle-timer)))

(defun told (text)
  "Whether a message had TEXT."
  (cl-some (lambda (line) (string-search text line)) init-messages))

(defun open-program ()
  "Open the program that the command line names, and have the server at work."
  (find-file (getenv "IMPROV_PROGRAM"))
  (run-hooks 'post-command-hook)
  (await "server" (eglot-managed-p)))

(defun at (word)
  "Go to the first WORD."
  (goto-char (point-min))
  (re-search-forward (concat "\\_<" word "\\_>"))
  (goto-char (match-beginning 0)))

(defun exchange (word other)
  "Write OTHER in place of the first WORD."
  (at word)
  (delete-region (match-beginning 0) (match-end 0))
  (insert other))

(defun save ()
  "Save as by \\[save-buffer]."
  (setq init-messages nil)
  (save-buffer))

(defun problems ()
  "What Flymake has to say, and on what."
  (flymake-start)
  (mapcar (lambda (each) (cons (buffer-substring (flymake-diagnostic-beg each) (flymake-diagnostic-end each))
                               (flymake-diagnostic-text each)))
          (flymake-diagnostics)))

(defun lit ()
  "The words that are lit, with their lines."
  (sort (cl-loop for overlay in (overlays-in (point-min) (point-max))
                 when (eq (overlay-get overlay 'face) 'improv-playing)
                 collect (cons (line-number-at-pos (overlay-start overlay))
                               (buffer-substring (overlay-start overlay) (overlay-end overlay))))))

(defun left-behind ()
  "What reminds of a dance: overlays in this buffer."
  (cl-remove-if-not (lambda (overlay) (overlay-get overlay 'improv-playing)) (overlays-in (point-min) (point-max))))

(defun mode-line ()
  "What the mode line says of what plays; in batch, Emacs itself makes none."
  (or (pcase mode-line-process (`(:eval ,form) (eval form t))) ""))

(defun beat ()
  "The beat in the mode line, if that says what is to be said of a dance without end."
  (and (string-match " ▶ beat \\([0-9]+\\)/∞, 120 beats/min, simulator\\'" (mode-line))
       (string-to-number (match-string 1 (mode-line)))))

(defun robot (does)
  "Wait until a robot of the simulator DOES it: moves or stands."
  (let* ((default-directory (file-name-as-directory (getenv "IMPROV_ROOT")))
         (process-connection-type nil)
         (buffer (generate-new-buffer " *robot*"))
         (process (start-process "robot" buffer (getenv "IMPROV_PYTHON") "-m" "tests.editors.robot" init-page does)))
    ;; Emacs goes on hearing the server, as it does while nobody keeps it busy: that waits for who does not read on.
    (while (process-live-p process) (accept-process-output nil 0.05))
    (check (eq 0 (process-exit-status process)) does (with-current-buffer buffer (buffer-string)))
    (kill-buffer buffer)
    (princ (format "robot %s\n" does))))

;;; steps.el ends here
