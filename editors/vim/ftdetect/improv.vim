autocmd BufNewFile,BufRead *.improv setfiletype improv
