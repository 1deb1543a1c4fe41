#!/usr/bin/env python3
# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0

"""Checks the documents and the site that is built from them.

check.py links ROOT SITE          every link of the repository's Markdown files, and of the site, leads somewhere, no
                                  page of the site needs the network, and the tests behind promises exist
check.py pages SITE SCREENSHOTS   looks at every page with Chromium, in a wide and in a narrow window: text stands out
                                  from its background, nothing is wider than the window, pictures have a fitting size,
                                  formulas are drawn, nothing fails to load; keeps a screenshot of each
"""

import base64
import fcntl
import glob
import html.parser
import json
import os
import re
import select
import shutil
import subprocess
import sys
import tempfile
import time
import urllib.parse

import markdown

problems = []


def read(path):
    with open(path, encoding='utf-8') as file:
        return file.read()


# Links

def check_markdown(root):
    documents = []
    for parent, folders, names in os.walk(root):
        folders[:] = [name for name in folders if not re.match(r'build|\.', name)]  # build may hold whole systems
        documents += [os.path.join(parent, name) for name in names if name.endswith(('.md', '.markdown'))]
    anchors = {}
    for path in documents:
        text = markdown.FENCE.sub('', read(path))
        headings = re.findall(r'^#+ (.*?)(?: {#[\w-]+})?$|^(.+?)(?: {#[\w-]+})?\n(?:=+|-+)$', text, re.MULTILINE)
        anchors[os.path.realpath(path)] = {markdown.slug(a or b) for a, b in headings}
    count = 0
    for path in documents:
        text = markdown.FENCE.sub('', read(path))
        for _, _, target in markdown.LINK.findall(text):
            if re.match(r'\w+:|@ref', target):
                continue
            count += 1
            file, _, anchor = target.partition('#')
            full = os.path.realpath(os.path.join(os.path.dirname(path), file)) if file else os.path.realpath(path)
            if not os.path.exists(full) or (anchor and anchor not in anchors.get(full, ())):
                problems.append(f'{os.path.relpath(path, root)}: the link to {target} leads nowhere')
    print(f'{len(documents)} Markdown files with {count} links inside of the repository')


def check_tests(root):
    """The tests that the page of promises names exist."""
    sources = ''.join(read(path) for path in glob.glob(os.path.join(root, 'test', '*.cpp')))
    tests = {f'{suite}.{name}'
             for suite, name in re.findall(r'^TEST(?:_P)?\(Aqorb_(\w+), (\w+)\)', sources, re.MULTILINE)}
    suites = {test.partition('.')[0] for test in tests}
    path = os.path.join(root, 'modules/aqorb/tutorials/aqorb_promises/aqorb_promises.markdown')
    named = re.findall(r'`([A-Z]\w+)\.(\w+|\*)`', read(path))
    for suite, name in named:
        if suite not in suites if name == '*' else f'{suite}.{name}' not in tests:
            problems.append(f'{os.path.basename(path)}: there is no test {suite}.{name}')
    print(f'{len(named)} names of tests behind promises')


class Page(html.parser.HTMLParser):
    """The anchors of a page, its links, and what it loads."""

    def __init__(self, path):
        super().__init__()
        self.anchors, self.links, self.loaded = set(), [], []
        self.feed(read(path))

    def handle_starttag(self, tag, attrs):
        attrs = dict(attrs)
        self.anchors.update(attrs[name] for name in ('id', 'name') if attrs.get(name))
        for name in ('href', 'src', 'data', 'xlink:href'):
            if attrs.get(name):
                (self.links if tag in ('a', 'area') else self.loaded).append(attrs[name])

    handle_startendtag = handle_starttag


def check_site(site):
    paths = glob.glob(os.path.join(site, '*.html')) + glob.glob(os.path.join(site, '*.svg'))
    pages = {path: Page(path) for path in paths}
    count = 0

    def check(path, target):
        nonlocal count
        count += 1
        file, _, anchor = urllib.parse.unquote(target).partition('#')
        full = os.path.normpath(os.path.join(os.path.dirname(path), file)) if file else path
        inside = full.startswith(os.path.abspath(site) + os.sep)
        if not inside or not os.path.isfile(full) or (anchor and anchor not in pages[full].anchors):
            problems.append(f'{os.path.basename(path)}: the link to {target} leads nowhere in the site')

    for path, page in pages.items():
        for target in page.links:
            if not re.match(r'(https?|mailto|javascript):', target):
                check(path, target)
        for target in page.loaded:
            if not re.match(r'javascript:|#', target):
                check(path, target)  # the address of another host does not pass either
    for path in glob.glob(os.path.join(site, '**', '*.css'), recursive=True):
        for target in re.findall(r'url\(["\']?([^"\')]+)', read(path)):
            if re.match(r'\w+:|/', target) and not target.startswith('data:'):  # the browser misses what is absent
                problems.append(f'{os.path.basename(path)} needs {target}')
    for target in re.findall(r'url:"([^"]+)"', read(os.path.join(site, 'menudata.js'))):
        check(os.path.join(site, 'index.html'), target)
    for path in glob.glob(os.path.join(site, 'search', '*.js')):
        for target in re.findall(r"""["']\.\./([^"']+)["']""", read(path)):
            check(os.path.join(site, 'index.html'), target)
    print(f'{len(pages)} pages and graphs with {count} links inside of the site')


# Pages in a browser

# Runs in the page, and returns a list of sentences.
LOOK = r'''
(async () => {
    const problems = new Set();
    if (window.MathJax && MathJax.Hub)
        await new Promise(resolve => MathJax.Hub.Queue(resolve));
    await Promise.all([...document.images].map(image => image.decode().catch(() => 0)));

    const parse = text => {
        const parts = text.match(/[\d.]+/g).map(Number);
        return {rgb: parts.slice(0, 3), alpha: parts.length > 3 ? parts[3] : 1};
    };
    const over = (top, alpha, below) => top.map((value, i) => value * alpha + below[i] * (1 - alpha));
    const luminance = rgb => {
        const linear = rgb.map(v => v / 255).map(v => v <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
        return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2];
    };
    const background = element => {
        const layers = [];
        for (let e = element; e; e = e.parentElement) {
            const style = getComputedStyle(e);
            if (style.backgroundImage.includes('gradient') || style.backgroundImage.includes('url')) {
                const area = style.backgroundRepeat !== 'no-repeat';
                if (area)
                    return null;
            }
            const color = parse(style.backgroundColor);
            layers.push(color);
            if (color.alpha === 1)
                break;
        }
        return layers.reverse().reduce((below, layer) => over(layer.rgb, layer.alpha, below), [255, 255, 255]);
    };

    for (const menu of document.querySelectorAll('.sm-dox ul'))
        menu.style.display = 'block';
    const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    const ratios = new Map();
    let texts = 0;
    for (let node = walker.nextNode(); node; node = walker.nextNode()) {
        const element = node.parentElement;
        const text = node.textContent.trim();
        if (!text || element.closest('script, style, noscript, .MathJax_Preview, #MathJax_Message, mjx-assistive-mml'))
            continue;
        if (!element.checkVisibility({opacityProperty: true, visibilityProperty: true}))
            continue;
        texts++;
        if (/\*\*|`|\]\(/.test(text) && !element.closest('code, pre, .fragment'))
            problems.add(`not understood as Markdown: "${text.slice(0, 60)}"`);
        if (/\\\(|\\\[|\\f\[|@(ref|cite|code|subpage)\b|\\(ref|cite|subpage)\b/.test(text))
            problems.add(`left as it is in the source: "${text.slice(0, 60)}"`);
        if (!ratios.has(element)) {
            ratios.set(element, 0);
            const style = getComputedStyle(element);
            const below = background(element);
            const where = `"${text.slice(0, 40)}" in <${element.tagName.toLowerCase()} class="${element.className}">`;
            if (!below) {
                problems.add(`${where} stands on a picture`);
                continue;
            }
            const color = parse(style.color);
            const [a, b] = [luminance(over(color.rgb, color.alpha, below)), luminance(below)];
            const ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
            const size = parseFloat(style.fontSize), bold = Number(style.fontWeight) >= 700;
            const least = size >= 24 || (bold && size >= 18.66) ? 3 : 4.5;
            if (ratio < least)
                problems.add(`${where} has a contrast of ${ratio.toFixed(1)}, which is less than ${least}`);
            if (size < 12)
                problems.add(`${where} is ${size} pixels high`);
        }
    }
    for (const menu of document.querySelectorAll('.sm-dox ul'))
        menu.style.display = '';
    if (texts < 10)
        problems.add(`shows ${texts} pieces of text only`);

    const width = document.documentElement.clientWidth;
    if (document.documentElement.scrollWidth > width)
        problems.add(`is ${document.documentElement.scrollWidth} pixels wide in a window of ${width}`);
    for (const element of document.querySelectorAll('.contents *')) {
        const box = element.getBoundingClientRect(), around = element.parentElement.getBoundingClientRect();
        const scrolls = element.closest('.markdownTable, .doxtable, .fragment, .memproto, .dynsection, .dyncontent');
        if (box.width && box.right > width + 1 && around.right <= width + 1 && !scrolls)
            problems.add(`<${element.tagName.toLowerCase()} class="${element.className}"> ends at ${box.right}`);
    }
    for (const image of document.querySelectorAll('img')) {
        const box = image.getBoundingClientRect(), name = image.getAttribute('src');
        if (!image.naturalWidth)
            problems.add(`the picture ${name} does not load`);
        else if (!image.closest('.contents') && (box.width > 160 || box.height > 48))
            problems.add(`the picture ${name} beside the text is ${box.width} x ${box.height} pixels large`);
        else if (!name.endsWith('.svg') && box.width > image.naturalWidth + 1)
            problems.add(`the picture ${name} is enlarged from ${image.naturalWidth} to ${box.width} pixels`);
    }
    if (document.querySelector('.MathJax_Error, .merror, .MathJax_SVG_Error'))
        problems.add('a formula has an error');
    const formulas = window.MathJax && MathJax.Hub ? MathJax.Hub.getAllJax().length : 0;
    if (formulas !== document.querySelectorAll('.MathJax_SVG').length)
        problems.add('a formula is not drawn');
    return [...problems];
})()
'''

WINDOWS = {'wide': (1280, 900, False), 'narrow': (390, 844, True)}


class Browser:
    """Chromium without a window and without network, driven through a pipe by the DevTools protocol."""

    def __init__(self):
        program = shutil.which('chromium') or shutil.which('chromium-browser') or shutil.which('google-chrome')
        if not program:
            sys.exit('chromium is not installed')
        self.profile = tempfile.mkdtemp(prefix='aqorb-site-')
        commands, self.commands = os.pipe()
        self.answers, answers = os.pipe()
        # The protocol uses the descriptors 3 and 4, so copies beyond them are made first.
        spare = [os.dup(commands), os.dup(answers)]
        high = [self.above(fd) for fd in spare]

        def connect():
            os.dup2(high[0], 3)
            os.dup2(high[1], 4)
        self.process = subprocess.Popen(
            [program, '--headless', '--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run',
             '--disable-background-networking', '--disable-component-update', '--disable-sync',
             '--disable-dev-shm-usage', '--host-resolver-rules=MAP * ~NOTFOUND',
             f'--user-data-dir={self.profile}', '--remote-debugging-pipe', 'about:blank'],
            preexec_fn=connect, close_fds=False, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL, env=dict(os.environ, HOME=self.profile))
        for fd in [commands, answers] + spare + high:
            os.close(fd)
        self.buffer, self.number, self.events, self.session = b'', 0, [], None
        target = self.call('Target.createTarget', url='about:blank')['targetId']
        self.session = self.call('Target.attachToTarget', targetId=target, flatten=True)['sessionId']
        for domain in ('Page', 'Runtime', 'Log', 'Network'):
            self.call(f'{domain}.enable')

    @staticmethod
    def above(fd):
        return fcntl.fcntl(fd, fcntl.F_DUPFD, 10)

    def receive(self, deadline):
        while b'\0' not in self.buffer:
            if not select.select([self.answers], [], [], max(0, deadline - time.monotonic()))[0]:
                sys.exit('chromium does not answer')
            data = os.read(self.answers, 1 << 20)
            if not data:
                sys.exit('chromium has ended')
            self.buffer += data
        message, self.buffer = self.buffer.split(b'\0', 1)
        return json.loads(message)

    def call(self, method, **parameters):
        self.number += 1
        message = {'id': self.number, 'method': method, 'params': parameters}
        if self.session:
            message['sessionId'] = self.session
        os.write(self.commands, json.dumps(message).encode() + b'\0')
        deadline = time.monotonic() + 60
        while True:
            answer = self.receive(deadline)
            if answer.get('id') == self.number:
                if 'error' in answer:
                    sys.exit(f'chromium: {method}: {answer["error"]}')
                return answer['result']
            self.events.append(answer)

    def open(self, address):
        """Loads a page; returns what went wrong."""
        self.events = []
        self.call('Page.navigate', url=address)
        deadline = time.monotonic() + 60
        while not any(event.get('method') == 'Page.loadEventFired' for event in self.events):
            self.events.append(self.receive(deadline))

    def failures(self):
        for event in self.events:
            parameters = event.get('params', {})
            if event.get('method') == 'Network.loadingFailed' and not parameters.get('canceled'):
                yield f'something fails to load: {parameters.get("errorText")}'
            elif event.get('method') == 'Network.requestWillBeSent':
                address = parameters['request']['url']
                if not re.match(r'file:|data:|about:|blob:', address):
                    yield f'asks for {address}'
            elif event.get('method') == 'Runtime.exceptionThrown':
                details = parameters['exceptionDetails']
                yield f'a script fails: {details.get("exception", {}).get("description", details.get("text"))}'
            elif event.get('method') == 'Log.entryAdded' and parameters['entry']['level'] == 'error':
                yield f'an error is logged: {parameters["entry"]["text"]}'

    def evaluate(self, script):
        answer = self.call('Runtime.evaluate', expression=script, awaitPromise=True, returnByValue=True)
        if 'exceptionDetails' in answer:
            sys.exit(f'check.py: {answer["exceptionDetails"]}')
        return answer['result']['value']

    def close(self):
        self.session = None
        self.call('Browser.close')
        self.process.wait(60)
        shutil.rmtree(self.profile, ignore_errors=True)


def check_pages(site, screenshots):
    shutil.rmtree(screenshots, ignore_errors=True)
    os.makedirs(screenshots)
    browser = Browser()
    paths = sorted(glob.glob(os.path.join(site, '*.html')))
    for window, (width, height, mobile) in WINDOWS.items():
        browser.call('Emulation.setDeviceMetricsOverride', width=width, height=height, deviceScaleFactor=1,
                     mobile=mobile)
        # The narrow window asks for dark colours, too.
        scheme = 'dark' if mobile else 'light'
        browser.call('Emulation.setEmulatedMedia', features=[{'name': 'prefers-color-scheme', 'value': scheme}])
        for path in paths:
            name = os.path.basename(path)[:-len('.html')]
            browser.open('file://' + urllib.parse.quote(os.path.abspath(path)))
            found = browser.evaluate(LOOK) + list(browser.failures())
            shown = found[:10] + ([f'{len(found) - 10} problems more'] if len(found) > 10 else [])
            problems.extend(f'{name}.html, {window}: {problem}' for problem in shown)
            picture = browser.call('Page.captureScreenshot', captureBeyondViewport=True)
            with open(os.path.join(screenshots, f'{name}.{window}.png'), 'wb') as file:
                file.write(base64.b64decode(picture['data']))
    browser.close()
    print(f'{len(paths)} pages in {len(WINDOWS)} windows')


if __name__ == '__main__':
    if sys.argv[1:2] == ['links'] and len(sys.argv) == 4:
        check_markdown(sys.argv[2])
        check_tests(sys.argv[2])
        check_site(os.path.abspath(sys.argv[3]))
    elif sys.argv[1:2] == ['pages'] and len(sys.argv) == 4:
        check_pages(*sys.argv[2:])
    else:
        sys.exit(__doc__)
    if problems:
        sys.exit('\n'.join(dict.fromkeys(problems)))
