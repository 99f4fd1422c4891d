"""What the files of a build folder say, read and typed once, for printing, figures, report and exports."""
