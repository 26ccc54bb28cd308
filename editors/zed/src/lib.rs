// Starts the language server, and passes on its settings.

use zed_extension_api::{self as zed, serde_json::Value, settings::LspSettings, Command, LanguageServerId, Worktree};

struct Improv;

impl zed::Extension for Improv {
    fn new() -> Self {
        Improv
    }

    fn language_server_command(&mut self, _id: &LanguageServerId, worktree: &Worktree) -> zed::Result<Command> {
        let missing = || "improv-ls is not on the PATH: install Improv".to_string();
        let command = worktree.which("improv-ls").ok_or_else(missing)?;
        Ok(Command { command, args: Vec::new(), env: worktree.shell_env() })
    }

    fn language_server_workspace_configuration(
        &mut self,
        id: &LanguageServerId,
        worktree: &Worktree,
    ) -> zed::Result<Option<Value>> {
        Ok(LspSettings::for_worktree(id.as_ref(), worktree)?.settings)
    }
}

zed::register_extension!(Improv);
