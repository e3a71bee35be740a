"""Lightbox among other renderers: renders a scene that is given in neutral form, as often as asked.

`scenes` and `common` are the harness's own modules: `scenes.get(key)` gives the camera, the lamp
and the surfaces, `common.args` and `common.serve` take jobs (samples per pixel and a seed) and
write what each took and gave. The scene goes to `lightbox render` as TOML and OBJ, the picture
comes back as EXR, the seconds (tracing only) from `--json`. LIGHTBOX names the binary; a variant
is a method, or method-sampler. Needs numpy and OpenEXR.
"""
import json, os, subprocess, sys, tempfile, time
T0 = time.time()
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import common
import numpy as np
import scenes

BIN = os.environ.get('LIGHTBOX', 'lightbox')


def read_exr(path):
    import OpenEXR
    with OpenEXR.File(path) as f:
        ch = f.channels()
        if 'RGB' in ch:
            return np.array(ch['RGB'].pixels, np.float32)
        return np.stack([np.array(ch[c].pixels, np.float32) for c in 'RGB'], -1)


def vec(v):
    return '[' + ', '.join(repr(float(x)) for x in v) + ']'


def write(S, folder):
    c, L = S['camera'], S['light']
    o = [f"[camera]\neye = {vec(c['origin'])}\ntarget = {vec(c['target'])}\nup = {vec(c['up'])}\nfov = {c['hfov_deg']}\n"]
    o.append(f"[[material]]\nname = \"lamp\"\nalbedo = [0, 0, 0]\nemission = {vec(L['radiance'])}\n")
    for name, g, (k, p) in S['surfaces']:
        m = {'diffuse': lambda: f'albedo = {vec(p)}', 'mirror': lambda: f'mirror = 1.0\nmirror_color = {vec([p] * 3)}',
             'glass': lambda: f'glass = {float(p)}'}[k]()
        o.append(f'[[material]]\nname = "{name}"\n{m}\n')
        if g['kind'] == 'sphere':
            o.append(f"[[sphere]]\nname = \"{name}\"\nmaterial = \"{name}\"\ncenter = {vec(g['c'])}\nradius = {float(g['r'])}\n")
        elif len(g['f']) == 2:
            o.append(f'[[quad]]\nname = "{name}"\nmaterial = "{name}"\ncorners = [{", ".join(vec(v) for v in g["v"])}]\n')
        else:
            with open(f'{folder}/{name}.obj', 'w') as w:
                w.writelines('v %r %r %r\n' % tuple(map(float, v)) for v in g['v'])
                w.writelines('f %d %d %d\n' % tuple(f + 1) for f in g['f'])
            o.append(f'[[mesh]]\nname = "{name}"\nmaterial = "{name}"\nfile = "{name}.obj"\n')
    hx, hz, y = L['hx'], L['hz'], L['y']
    q = [(-hx, y, -hz), (hx, y, -hz), (hx, y, hz), (-hx, y, hz)]
    o.append(f'[[quad]]\nname = "lamp"\nmaterial = "lamp"\ncorners = [{", ".join(vec(v) for v in q)}]\n')
    path = f'{folder}/scene.toml'
    open(path, 'w').write('\n'.join(o))
    return path


def main():
    A = common.args()
    S = scenes.get(A.scene)
    method, _, sampler = (A.variant or 'mis').partition('-')
    with tempfile.TemporaryDirectory() as folder:
        path, out = write(S, folder), f'{folder}/out.exr'
        n = S['res']

        def render(spp, seed):
            cmd = [BIN, 'render', path, '-o', out, '--spp', str(spp), '--size', f'{n}x{n}', '--depth', str(S['max_scatter'] + 1),
                   '--filter', 'box', '--method', method, '--seed', str(seed), '--threads', str(A.threads), '--json']
            if sampler:
                cmd += ['--sampler', sampler]
            r = subprocess.run(cmd, stdout=subprocess.PIPE, text=True, check=True)
            j = json.loads(r.stdout)
            return read_exr(out), j['spp'], j['seconds']
        common.serve(A, 'lightbox', render, T0, 0.0)


main()
