"""The library behind `import tedm`: the stages and pure rooms from Python, with xarray for results.

It is a second door beside `cli`, as thin. What users import is `top_level/tedm`, which is installed as the package
`tedm`.
"""
