from martensite.boards.session import Session as Session
