vim.filetype.add { extension = { improv = "improv" } }
