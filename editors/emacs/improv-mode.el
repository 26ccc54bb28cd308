;;; improv-mode.el --- Live-code robot motion  -*- lexical-binding: t; -*-

;; Copyright (c) 2026 The Improv authors
;; SPDX-License-Identifier: MIT

;; Author: The Improv authors
;; Version: 0.1.0
;; Package-Requires: ((emacs "30.1"))
;; Keywords: languages, multimedia

;;; Commentary:

;; Write a few words of choreography, save, and robots move: in a simulator, or real ones over ROS 2.
;;
;; The language server `improv-ls' does the work.  Eglot talks to it:
;;
;;     (require 'improv-mode)
;;     (add-hook 'improv-mode-hook #'eglot-ensure)
;;     (add-hook 'improv-robots-mode-hook #'eglot-ensure)
;;
;; Saving a program plays it.  \\[improv-stop] stops all robots immediately.  The words that are playing are
;; highlighted, and the mode line shows the beat.

;;; Code:

(require 'improv-playing)
(require 'improv-words)

(defcustom improv-server-command '("improv-ls")
  "The command that starts the language server, and its arguments."
  :type '(repeat string)
  :group 'improv)

(add-to-list 'eglot-server-programs
             (cons '(improv-mode (improv-robots-mode :language-id "toml"))
                   (lambda (_interactive) (cons 'improv-eglot-server improv-server-command))))


;;; The mode

(defconst improv-mode--name "[[:alpha:]_][[:alnum:]_]*")

(defconst improv-mode--parameters
  (concat "\\(?:[ \t]+" improv-mode--name "\\)*\\(?:[ \t]*([ \t]*" improv-mode--name "[ \t]*)\\)*")
  "A regexp that matches the parameters in the head of a definition.")

(defconst improv-mode--statement
  (concat "\\(?:beat\\_>\\|---\\|" improv-mode--name
          "\\(?:" improv-mode--parameters "[ \t]*=\\|[[:alnum:]_ \t]*\\$\\)\\)")
  "A regexp that matches the beginning of a statement.")

(defconst improv-mode--continuation "||\\|else\\_>"
  "A regexp that matches the beginning of a line that continues a statement.")

(defvar improv-mode-font-lock-keywords
  `((,(concat "^[ \t]*\\(" improv-mode--name "\\)\\(" improv-mode--parameters "\\)[ \t]*=")
     (1 'font-lock-variable-name-face)
     (,improv-mode--name (improv-mode--enter-parameters) nil (0 'font-lock-variable-use-face)))
    (,(concat "^[ \t]*\\(---+\\)\\(?:[ \t]*\\(" improv-mode--name "\\)[ \t]*\\(?:#\\|$\\)\\)?")
     (1 'font-lock-preprocessor-face)
     (2 'font-lock-variable-name-face nil t))
    (improv-mode--match-kind
     (1 'font-lock-type-face)
     (2 'font-lock-preprocessor-face)
     (3 'font-lock-constant-face))
    (improv-mode--match-place
     (1 'font-lock-type-face nil t)
     (2 'font-lock-preprocessor-face)
     ("\\_<\\(?:facing\\|around\\)\\_>" (goto-char (match-end 2)) nil (0 'font-lock-preprocessor-face))
     ("\\_<\\(?:circle\\|line\\|grid\\|in\\|out\\)\\_>" (goto-char (match-end 2)) nil (0 'font-lock-constant-face))
     ("[-+]?[0-9]*\\.?[0-9]+\\(?:\\(?:cm\\|mm\\|m\\|deg\\)\\_>\\|°\\)?" (goto-char (match-end 2)) nil (0 'font-lock-number-face)))
    (,(regexp-opt improv-statement-words 'symbols) . 'font-lock-preprocessor-face)
    (,(regexp-opt improv-transformers 'symbols) . 'font-lock-keyword-face)
    (,(regexp-opt improv-conditionals 'symbols) . 'font-lock-keyword-face)
    (,(regexp-opt improv-primitives 'symbols) . 'font-lock-function-call-face)
    (,(regexp-opt improv-planes 'symbols) . 'font-lock-constant-face)
    (,(concat "\\(" improv-mode--name "\\(?:[ \t]+" improv-mode--name "\\)*\\)[ \t]*\\$") 1 'font-lock-type-face)
    ("\\_<[0-9]*\\.?[0-9]+\\(?:\\(?:cm\\|mm\\|m\\|deg\\)\\_>\\|°\\)?" . 'font-lock-number-face)
    ("||\\|[=$*/]" . 'font-lock-operator-face))
  "Font lock keywords, for buffers without a server.")

(defconst improv-mode--robots (concat "^[ \t]*\\(" improv-mode--name "\\(?:[ \t]+" improv-mode--name "\\)*?\\)[ \t]+")
  "A regexp that matches the robots at the beginning of a line.")

(defconst improv-mode--kind
  (concat improv-mode--robots "\\(is\\)[ \t]+\\(" improv-mode--name "\\(?:-+[[:alnum:]_]+\\)*\\)[ \t]*\\(?:#\\|$\\)")
  "A regexp that matches a line such as \"ada is puppet\".")

(defconst improv-mode--place
  (concat "\\(?:" improv-mode--robots "\\(?2:at\\)\\_>\\(?:[ \t]*[-+.0-9]\\|[ \t]+\\(?:circle\\|line\\|grid\\)\\_>\\)"
          "\\|^[ \t]*\\(?2:room\\|bar\\)\\_>[ \t]*[-+.0-9]\\)[^=$#\n]*\\(?:#\\|$\\)")
  "A regexp that matches a line such as \"ada at 1 2\", \"room 6 4\", or \"bar 3\".")

(defun improv-mode--match-kind (limit)
  "Find the next line before LIMIT such as \"ada is puppet\"."
  (improv-mode--match-opening improv-mode--kind limit))

(defun improv-mode--match-place (limit)
  "Find the next line before LIMIT such as \"ada at 1 2\" or \"room 6 4\"."
  (improv-mode--match-opening improv-mode--place limit))

(defun improv-mode--match-opening (line limit)
  "Find the next statement before LIMIT that matches LINE.
Within brackets, and where it begins with else, its words are names."
  (let (found)
    (while (and (setq found (re-search-forward line limit t))
                (save-excursion
                  (save-match-data
                    (goto-char (match-beginning 0))
                    (back-to-indentation)
                    (or (looking-at-p "else\\_>") (> (car (improv-mode--depth)) 0))))))
    found))

(defun improv-mode--enter-parameters ()
  "Go to the parameters that were just matched, and return where they end.
Font lock ignores an end at point, so that is one more if there are none."
  (goto-char (match-beginning 2))
  (max (match-end 2) (1+ (point))))

(defvar improv-mode-syntax-table
  (let ((table (make-syntax-table)))
    (modify-syntax-entry ?# "<" table)
    (modify-syntax-entry ?\n ">" table)
    (mapc (lambda (sign) (modify-syntax-entry sign "_" table)) "_.") ; a number, such as 1.5, is one symbol for Eglot
    (mapc (lambda (sign) (modify-syntax-entry sign "." table)) "$=|/+-*&<>%\"\\'`{}")
    table)
  "Brackets are ( ) and [ ], comments begin with #, and there are no strings.")

(defvar-keymap improv-mode-map
  :doc "Keys to play programs and to control playback."
  "C-c C-c" #'improv-play
  "C-c C-l" #'improv-play-this
  "C-c C-k" #'improv-stop
  "C-c C-p" #'improv-pause
  "C-c C-r" #'improv-resume
  "C-c C-b" #'improv-restart
  "C-c C-z" #'improv-before
  "C-c C-y" #'improv-history
  "C-c C-q" #'improv-cue
  "C-c C-s" #'improv-seek
  "C-c C-f" #'improv-speed
  "C-c RET" #'improv-mute
  "C-c C-o" #'improv-solo
  "C-c C-v" #'improv-page)

(easy-menu-define improv-mode-menu improv-mode-map "Menu to play programs and to control playback."
  '("Improv"
    ["Play This Program" improv-play]
    ["Play This Line or Region" improv-play-this]
    ["Play Only This Line or Region" (improv-play-this t)]
    ["Play a Name…" improv-play-name]
    ["Stop All Robots" improv-stop]
    ["Pause" improv-pause]
    ["Resume" improv-resume]
    ["Begin Although Robots Are Not in Their Places" improv-anyway]
    ["Play from the Beginning" improv-restart]
    ["Play the One Before" improv-before]
    ["Show History…" improv-history]
    ["Transcribe Recording…" improv-transcribe]
    ["Give the Cue" improv-cue]
    ["Hold or Release Key of a Sense…" improv-key]
    ["Go to Beat…" improv-seek]
    ["Set Speed…" improv-speed]
    ["Mute Robot…" improv-mute]
    ["Solo Robot…" improv-solo]
    ["Show Robots in Browser" improv-page]
    ["Calibrate a Robot" improv-calibrate]))

;;;###autoload
(define-derived-mode improv-mode prog-mode "Improv"
  "Major mode for Improv programs.  Save a program, and robots move.

\\{improv-mode-map}"
  (setq-local font-lock-defaults '(improv-mode-font-lock-keywords)
              comment-start "# "
              comment-start-skip "#+[ \t]*"
              indent-line-function #'improv-mode-indent-line
              indent-tabs-mode nil
              electric-indent-chars (append ")]" electric-indent-chars)
              imenu-generic-expression `((nil ,(concat "^[ \t]*\\(" improv-mode--name "\\)" improv-mode--parameters "[ \t]*=") 1))
              mode-line-process '(:eval (improv-playing-status)))
  (add-hook 'after-save-hook #'improv-playing-saved nil t)
  (add-hook 'eglot-managed-mode-hook #'improv-playing-managed nil t)
  (add-hook 'eglot-managed-mode-hook #'improv-playing-leave nil t))

;;;###autoload
(add-to-list 'auto-mode-alist '("\\.improv\\'" . improv-mode))

;;;###autoload
(define-derived-mode improv-robots-mode conf-toml-mode "Improv Robots"
  "Major mode for improv.toml: the server starts for no other TOML file."
  (modify-syntax-entry ?. "." improv-robots-mode-syntax-table)) ; Eglot completes only the word behind the point

;;;###autoload
(add-to-list 'auto-mode-alist '("/improv\\.toml\\'" . improv-robots-mode))

(defun improv-mode-indent-line ()
  "Indent by two spaces for each open bracket, as the formatter does.
A statement that continues on a line of its own is indented once more there."
  (interactive)
  (let ((column (save-excursion (back-to-indentation) (improv-mode--indentation))))
    (if (<= (current-column) (current-indentation))
        (indent-line-to column)
      (save-excursion (indent-line-to column)))))

(defun improv-mode--indentation ()
  "Return the column for the code that begins at point."
  (pcase-let ((`(,depth . ,continued) (improv-mode--depth)))
    (cond ((and (looking-at-p improv-mode--statement) (not (looking-at-p improv-mode--continuation))) 0)
          ((<= depth 0) (if (looking-at-p improv-mode--continuation) 2 0))
          (t (* 2 (+ depth (if (looking-at-p "[])]") -1 0) (if continued 1 0)))))))

(defun improv-mode--depth ()
  "Return how many brackets are open at point, and whether a line continues.
Only lines of the statement at point count."
  (let ((here (point)) continued)
    (save-excursion
      (re-search-backward (concat "^[ \t]*" improv-mode--statement) nil 'move)
      (let ((start (point)))
        (while (re-search-forward (concat "^[ \t]*\\(" improv-mode--continuation "\\)") here t)
          (when (<= (car (parse-partial-sexp start (match-beginning 1))) 0)
            (setq continued t)))
        (cons (car (parse-partial-sexp start here)) continued)))))


;;; Commands

(defun improv-play ()
  "Play the program in this buffer from the beginning, saved or not."
  (interactive nil improv-mode)
  (improv--play))

(defun improv-play-this (&optional alone)
  "Play the region, or else the line at point, while all other robots dance on.
With ALONE, the prefix argument, they stop."
  (interactive "P" improv-mode)
  (let ((beg (if (use-region-p) (region-beginning) (point)))
        (end (if (use-region-p) (region-end) (point))))
    (improv--play (if (eglot-managed-p)
                      (list :start (eglot--pos-to-lsp-position beg) :end (eglot--pos-to-lsp-position end))
                    (line-number-at-pos beg t))
                  alone)))

(defun improv-play-name (name &optional alone)
  "Play what NAME stands for, while all other robots dance on.
With ALONE, the prefix argument, they stop."
  (interactive (list (read-string (format-prompt "Play" (thing-at-point 'symbol)) nil nil (thing-at-point 'symbol))
                     current-prefix-arg)
               improv-mode)
  (improv--play name alone))

(defun improv--play (&optional some alone)
  "Play the program, or SOME of it: a range, a line, or a name; perhaps ALONE."
  (let* ((file (or buffer-file-name (user-error "Save this buffer to a file first")))
         (arguments (cons (eglot-path-to-uri file) (and some (list some)))))
    (unless (improv-playing-wait arguments)
      (apply #'improv--execute (if alone "improv.only" "improv.play") arguments))))

;;;###autoload
(defun improv-stop ()
  "Stop all robots immediately.  This works in every buffer."
  (interactive)
  (dolist (server (or (improv-playing-servers)
                      (unless (improv-playing-forget) (user-error "Improv's language server is not running"))))
    (jsonrpc-async-request server :workspace/executeCommand '(:command "improv.stop" :arguments []))))

;;;###autoload
(define-obsolete-function-alias 'improv-hush #'improv-stop "0.1")

(defun improv-pause ()
  "Pause all robots.  \\[improv-resume] resumes."
  (interactive nil improv-mode)
  (improv--execute "improv.pause"))

(defun improv-resume ()
  "Resume after \\[improv-pause]."
  (interactive nil improv-mode)
  (improv--execute "improv.resume"))

(defun improv-anyway ()
  "Begin although robots are not in their places."
  (interactive nil improv-mode)
  (improv--execute "improv.anyway"))

(defun improv-restart ()
  "Play the current or last program from the beginning."
  (interactive nil improv-mode)
  (improv--execute "improv.restart"))

(defun improv-before ()
  "Play the version of this program that played before.
Use it again to go back further."
  (interactive nil improv-mode)
  (improv--execute "improv.before" (eglot-path-to-uri (or buffer-file-name (user-error "Save this buffer to a file first")))))

(defun improv-history (id)
  "Show the program with this ID in the history, to read and to copy from."
  (interactive (list (improv--read-played)) improv-mode)
  (let ((text (or (improv--ask "improv.history" id) (user-error "It is no longer in the history"))))
    (with-current-buffer (get-buffer-create "*Improv history*")
      (let ((inhibit-read-only t) improv-mode-hook)
        (erase-buffer)
        (insert text)
        (goto-char (point-min))
        (improv-mode)
        (setq buffer-read-only t))
      (pop-to-buffer (current-buffer)))))

(defun improv-transcribe (file)
  "Insert the program for the paths in FILE, a recording or a drawing."
  (interactive "fRecording or drawing: " improv-mode)
  (when-let* ((text (improv--ask "improv.transcribe" (expand-file-name file))))
    (insert text)))

(defun improv-cue ()
  "Give the cue that robots wait for."
  (interactive nil improv-mode)
  (improv--execute "improv.cue"))

(defun improv-key (key)
  "Hold the KEY of a sense until you use this again or the dance stops."
  (interactive "cKey of the sense: " improv-mode)
  (improv--execute "improv.key" (char-to-string key)))

(defun improv-seek (beat)
  "Continue from BEAT, counted from 0.  Real robots stay where they are."
  (interactive "nGo to beat (counted from 0): " improv-mode)
  (improv--execute "improv.seek" beat))

(defun improv-speed (factor)
  "Play FACTOR times as fast, until you change it again."
  (interactive "nSpeed (0.1 to 4, 1 is normal): " improv-mode)
  (improv--execute "improv.speed" factor))

(defun improv-mute (robot)
  "Keep ROBOT still while the others play, or unmute it if it is muted."
  (interactive (list (improv--read-robot "Mute")) improv-mode)
  (improv--execute "improv.mute" robot))

(defun improv-solo (robot)
  "Keep all robots except ROBOT still, or let them play again."
  (interactive (list (improv--read-robot "Solo")) improv-mode)
  (improv--execute "improv.solo" robot))

(defun improv-page ()
  "Show the simulated robots in the browser."
  (interactive nil improv-mode)
  (improv--execute "improv.page"))

(defun improv-calibrate ()
  "Show how to calibrate a robot in a terminal."
  (interactive nil improv-mode)
  (improv--execute "improv.calibrate"))

(defun improv--read-robot (what)
  "Ask which of the current robots to WHAT, such as \"Mute\"."
  (completing-read (concat what " robot: ") (improv-playing-robots (improv--server))))

(defun improv--read-played ()
  "Ask for one of the programs that played, the latest first.  Return its id."
  (let ((programs (mapcar (lambda (each)
                            (cons (format "%s  %s  %s" (plist-get each :played) (plist-get each :name) (plist-get each :line))
                                  (plist-get each :id)))
                          (improv--ask "improv.history"))))
    (unless programs
      (user-error "Nothing has played yet"))
    (cdr (assoc (completing-read "Program that played: "
                                 (lambda (string predicate action)
                                   (if (eq action 'metadata)
                                       '(metadata (display-sort-function . identity))
                                     (complete-with-action action programs string predicate)))
                                 nil t)
                programs))))

(defun improv--ask (command &rest arguments)
  "Have the server execute COMMAND with ARGUMENTS, and return its answer."
  (jsonrpc-request (improv--server) :workspace/executeCommand
                   (list :command command :arguments (vconcat arguments))))

(defun improv--execute (command &rest arguments)
  "Have the server execute COMMAND with ARGUMENTS.
It first receives everything that was typed."
  (eglot-execute (improv--server) (list :command command :arguments (vconcat arguments))))

(defun improv--server ()
  "Return the server of this buffer; signal an error if there is none."
  (or (improv-playing-server)
      (user-error (substitute-command-keys "Improv's language server is not running here; start it with \\[eglot]"))))

(provide 'improv-mode)
;;; improv-mode.el ends here
