;;; init.el --- A user's, as editors/emacs/README.md has it, with the server under test  -*- lexical-binding: t; -*-

;;; Code:

(setq native-comp-enable-subr-trampolines nil native-comp-jit-compilation nil) ; it is not to compile in the test

(add-to-list 'load-path (getenv "IMPROV_PACKAGE"))
(require 'improv-mode)
(add-hook 'improv-mode-hook #'eglot-ensure)
(add-hook 'improv-robots-mode-hook #'eglot-ensure)
(setq improv-server-command (list (getenv "IMPROV_PYTHON") "-m" "improv_ls"))
(setq-default eglot-workspace-configuration '(:improv (:backend "sim")))

;; The person's browser: it only notes the address.
(defvar init-page nil)
(setq browse-url-browser-function (lambda (url &rest _) (setq init-page url)))

;; Emacs in batch keeps no *Messages*.
(defvar init-messages nil)
(advice-add 'message :before (lambda (&rest what) (when (car what) (push (apply #'format-message what) init-messages))))

;;; init.el ends here
