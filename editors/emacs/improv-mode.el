;;; improv-mode.el --- Live-code robot motion  -*- lexical-binding: t; -*-

;; Copyright (c) 2026 The Improv authors
;; SPDX-License-Identifier: MIT

;; Author: The Improv authors
;; Version: 0.1.0
;; Package-Requires: ((emacs "30.1"))
;; Keywords: languages, multimedia

;;; Commentary:

;; Write a few words of choreography, save, and robots move: in the simulator, or in the room over ROS 2.
;;
;; `improv-ls', the language server, does the work; Eglot talks to it:
;;
;;     (require 'improv-mode)
;;     (add-hook 'improv-mode-hook #'eglot-ensure)
;;
;; Saving plays.  \\[improv-hush] stops every robot at once.  The words that play are lit, and the mode line has the
;; beat.

;;; Code:

(require 'improv-playing)
(require 'improv-words)

(defcustom improv-server-command '("improv-ls")
  "The program that is the language server, and its arguments."
  :type '(repeat string)
  :group 'improv)

(add-to-list 'eglot-server-programs
             (cons 'improv-mode (lambda (_interactive) (cons 'improv-eglot-server improv-server-command))))


;;; The mode

(defconst improv-mode--name "[[:alpha:]_][[:alnum:]_]*")

(defconst improv-mode--statement
  (concat "\\(?:beat\\_>\\|" improv-mode--name "[ \t]*\\(?:=\\|[[:alnum:]_ \t]*\\$\\)\\)")
  "How a statement begins.")

(defvar improv-mode-font-lock-keywords
  `((,(regexp-opt improv-statement-words 'symbols) . 'font-lock-preprocessor-face)
    (,(regexp-opt improv-transformers 'symbols) . 'font-lock-keyword-face)
    (,(regexp-opt improv-primitives 'symbols) . 'font-lock-function-call-face)
    (,(regexp-opt improv-planes 'symbols) . 'font-lock-constant-face)
    (,(concat "\\(" improv-mode--name "\\)[ \t]*=") 1 'font-lock-variable-name-face)
    (,(concat improv-mode--name "\\(?:[ \t]+" improv-mode--name "\\)*[ \t]*\\$") . 'font-lock-type-face)
    ("\\_<[0-9]*\\.?[0-9]+\\(?:/[0-9]*\\.?[0-9]+\\)?" . 'font-lock-number-face)
    ("||\\|[=$]" 0 'font-lock-operator-face t))
  "The colors of the language, without a server.")

(defvar improv-mode-syntax-table
  (let ((table (make-syntax-table)))
    (modify-syntax-entry ?# "<" table)
    (modify-syntax-entry ?\n ">" table)
    (modify-syntax-entry ?_ "_" table)
    (mapc (lambda (sign) (modify-syntax-entry sign "." table)) "$=|/.+-*&<>%\"\\'`{}")
    table)
  "Brackets are ( ) and [ ], a comment begins with #, and nothing is a string.")

(defvar-keymap improv-mode-map
  :doc "Save to play; these keys conduct."
  "C-c C-c" #'improv-play
  "C-c C-k" #'improv-hush
  "C-c C-p" #'improv-pause
  "C-c C-r" #'improv-resume
  "C-c C-b" #'improv-restart
  "C-c C-s" #'improv-seek
  "C-c C-f" #'improv-speed
  "C-c RET" #'improv-mute
  "C-c C-o" #'improv-solo
  "C-c C-v" #'improv-page)

(easy-menu-define improv-mode-menu improv-mode-map "What can be done with what plays."
  '("Improv"
    ["Play this file" improv-play]
    ["Stop every robot" improv-hush]
    ["Pause" improv-pause]
    ["Resume" improv-resume]
    ["Play again from the beginning" improv-restart]
    ["Go on from a beat…" improv-seek]
    ["Play so much faster…" improv-speed]
    ["Mute a robot…" improv-mute]
    ["Solo a robot…" improv-solo]
    ["Show the robots in the browser" improv-page]))

;;;###autoload
(define-derived-mode improv-mode prog-mode "Improv"
  "Major mode for Improv: write a few words, save, and robots move.

\\{improv-mode-map}"
  (setq-local font-lock-defaults '(improv-mode-font-lock-keywords)
              comment-start "# "
              comment-start-skip "#+[ \t]*"
              indent-line-function #'improv-mode-indent-line
              indent-tabs-mode nil
              electric-indent-chars (append ")]" electric-indent-chars)
              imenu-generic-expression `((nil ,(concat "^[ \t]*\\(" improv-mode--name "\\)[ \t]*=") 1))
              mode-line-process '(:eval (improv-playing-status)))
  (add-hook 'eglot-managed-mode-hook #'improv-playing-leave nil t))

;;;###autoload
(add-to-list 'auto-mode-alist '("\\.improv\\'" . improv-mode))

(defun improv-mode-indent-line ()
  "Indent by two blanks for each bracket that is open, as the formatter does."
  (interactive)
  (let ((column (save-excursion (back-to-indentation) (improv-mode--indentation))))
    (if (<= (current-column) (current-indentation))
        (indent-line-to column)
      (save-excursion (indent-line-to column)))))

(defun improv-mode--indentation ()
  "The column for what begins at point."
  (cond ((looking-at-p improv-mode--statement) 0)
        ((looking-at-p "[])]") (* 2 (max (1- (improv-mode--depth)) 0)))
        (t (* 2 (max (improv-mode--depth) 0)))))

(defun improv-mode--depth ()
  "How many brackets are open at point in its statement.
A statement begins anew, whatever was left open above."
  (let ((here (point)))
    (save-excursion
      (re-search-backward (concat "^[ \t]*" improv-mode--statement) nil 'move)
      (car (parse-partial-sexp (point) here)))))


;;; Commands

(defun improv-play ()
  "Play this file from beat 0, as it is in the buffer."
  (interactive nil improv-mode)
  (improv--execute "improv.play" (eglot-path-to-uri (or buffer-file-name (user-error "Save this buffer to a file first")))))

;;;###autoload
(defun improv-hush ()
  "Stop every robot at once, from whatever buffer."
  (interactive)
  (dolist (server (or (improv-playing-servers) (user-error "No language server of Improv is at work")))
    (jsonrpc-async-request server :workspace/executeCommand '(:command "improv.hush" :arguments []))))

(defun improv-pause ()
  "Stop every robot, to go on from there with \\[improv-resume]."
  (interactive nil improv-mode)
  (improv--execute "improv.pause"))

(defun improv-resume ()
  "Go on after \\[improv-pause]."
  (interactive nil improv-mode)
  (improv--execute "improv.resume"))

(defun improv-restart ()
  "Play again from beat 0 what plays, or played last."
  (interactive nil improv-mode)
  (improv--execute "improv.restart"))

(defun improv-seek (beat)
  "Go on from BEAT, counted from 0; real robots stay where they are."
  (interactive "nGo on from beat (counted from 0): " improv-mode)
  (improv--execute "improv.seek" beat))

(defun improv-speed (factor)
  "Play FACTOR times as fast, now and later."
  (interactive "nHow many times as fast (0.1 to 4): " improv-mode)
  (improv--execute "improv.speed" factor))

(defun improv-mute (robot)
  "Have ROBOT stand still while the others play; once more, and it plays again."
  (interactive (list (improv--read-robot "Mute")) improv-mode)
  (improv--execute "improv.mute" robot))

(defun improv-solo (robot)
  "Have all robots but ROBOT stand still; once more, and they play again."
  (interactive (list (improv--read-robot "Solo")) improv-mode)
  (improv--execute "improv.solo" robot))

(defun improv-page ()
  "Show the robots in the browser."
  (interactive nil improv-mode)
  (let ((page (or (plist-get (slot-value (improv--server) 'transport) :page)
                  (user-error "There is no page yet: save a program first"))))
    (message "The page is at %s" page) ; no browser may come up
    (browse-url page)))

(defun improv--read-robot (what)
  "Ask for a robot to do WHAT with, one of those that play."
  (completing-read (concat what " robot: ") (improv-playing-robots (improv--server))))

(defun improv--execute (command &rest arguments)
  "Have the server do COMMAND with ARGUMENTS, after what was typed."
  (eglot-execute (improv--server) (list :command command :arguments (vconcat arguments))))

(defun improv--server ()
  "The server of this buffer; without one, an error with advice."
  (or (improv-playing-server)
      (user-error (substitute-command-keys "Improv's language server is not at work here: start it by \\[eglot]"))))

(provide 'improv-mode)
;;; improv-mode.el ends here
