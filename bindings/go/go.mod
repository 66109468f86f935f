module htree

go 1.19
