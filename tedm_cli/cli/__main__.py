from tedm_cli.cli import main

main()
